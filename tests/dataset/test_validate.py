"""Each check must be able to fail: one defect a row, and the check that has to find it."""

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.defects import (
    BOP,
    KITTI,
    black,
    copy,
    drop_last,
    edit_image,
    edit_json,
    edit_points,
    edit_text,
    flat,
    pockets_of,
    runs_of,
    set_pixel,
    shift,
    turn_symmetry,
    upside_down,
)
from tests.dataset.faults.table import FAULTS
from tests.dataset.toy import make_dataset, make_manifest
from warehouse_sim.dataset.validate import Check, validate

CHECKS = [
    "manifest",
    "objects",
    "scene records",
    "bop files",
    "bop models",
    "bop tables",
    "bop cameras",
    "bop coco",
    "bop targets",
    "bop images",
    "bop masks",
    "bop exact images",
    "bop poses on images",
    "kitti files",
    "kitti labels",
    "kitti labels on images",
    "kitti calib",
    "kitti images",
    "kitti points in boxes",
    "kitti points on depth",
    "kitti sweeps",
    "kitti and bop labels",
    "kitti and bop images",
]


def failed(checks: list[Check]) -> set[str]:
    return {check.name for check in checks if not check.ok}


def test_good_dataset_passes_every_check(toy_root: Path) -> None:
    checks = validate(toy_root)
    assert [(check.name, check.ok) for check in checks] == [(name, True) for name in CHECKS]
    details = {check.name: check.detail for check in checks}
    assert details["manifest"] == "3 scenes (train 1, val 1, test 1), disjoint by scene"
    assert details["bop masks"] == "9 pairs of masks"
    assert details["bop poses on images"].startswith("9 targets: mean shift 0.000 px")
    assert details["kitti labels"] == "9 labels of 15 fields"


@pytest.mark.parametrize("formats", [("bop",), ("kitti",)])
def test_single_formats_have_their_own_checks(tmp_path: Path, formats: tuple[str, ...]) -> None:
    checks = validate(make_dataset(tmp_path / "data", make_manifest(formats=formats)))
    assert failed(checks) == set()
    shared = ("manifest", "objects", "scene records")
    assert [check.name for check in checks if check.name not in shared] == [
        name for name in CHECKS if name.startswith(formats[0]) and " and " not in name
    ]


def test_black_image_is_found_without_bop_files(tmp_path: Path) -> None:
    root = make_dataset(tmp_path / "data", make_manifest(formats=("kitti",)))
    edit_image(KITTI / "image_2/000000.png", black)(root)
    assert failed(validate(root)) == {"kitti images"}


GT, INFO, COCO, CAMERA = (BOP / f"scene_{name}.json" for name in ("gt", "gt_info", "gt_coco", "camera"))
LABEL, CALIB = KITTI / "label_2/000000.txt", KITTI / "calib/000000.txt"
POINTS, IDS, BEAMS = (KITTI / f"{kind}/000000.bin" for kind in ("velodyne", "velodyne_ids", "velodyne_beams"))
LABEL_READERS = "kitti labels, kitti labels on images, kitti points in boxes, kitti and bop labels"
LENS = {"cam_distortion": [-0.2, 0.05, 0, 0, 0]}
DEFECTS: dict[str, tuple[Callable[[Path], object], str]] = {
    "symmetry is no group": (edit_json("objects.json", lambda d: turn_symmetry(d["1"])), "objects, bop models"),
    "diameter differs": (edit_json("bop/models_eval/models_info.json", flat("1", diameter=9.0)), "bop models"),
    "diameter a little off": (edit_json("objects.json", flat("1", diameter=1.42)), "objects, bop models"),
    "record too many": (copy("scenes/000001.json", "scenes/000003.json"), "scene records"),
    "instance twice": (
        edit_json("scenes/000001.json", lambda d: d["objects"].append(d["objects"][0])),
        "scene records",
    ),
    "image too many": (copy(BOP / "rgb/000000.png", BOP / "rgb/000007.png"), "bop files"),
    "scene in two splits": (lambda root: shutil.copytree(root / BOP, root / "bop/test/000000"), "bop files"),
    "pose moved by 1 mm": (
        edit_json(GT, lambda d: shift(d["0"][1]["cam_t_m2c"], 1.0)),
        "bop tables",
    ),
    "wrong COCO area": (edit_json(COCO, lambda d: d["annotations"][0].update(area=3)), "bop coco"),
    "COCO file outside": (edit_json(COCO, lambda d: d["images"][0].update(file_name="../../x.png")), "bop coco"),
    "COCO runs without the closing change": (runs_of(lambda runs: [*runs[:-2], sum(runs[-2:])]), "bop masks"),
    "COCO runs beyond the image": (runs_of(lambda runs: [*runs, 9]), "bop masks"),
    "COCO run below zero": (runs_of(lambda runs: [runs[0] + 5, -5, *runs[1:]]), "bop masks"),
    "image missing in targets": (edit_json("bop/test_targets_bop24.json", drop_last), "bop targets"),
    "black image": (edit_image(BOP / "rgb/000000.png", black), "bop images, kitti and bop images"),
    "depth 20 cm off": (
        edit_image(BOP / "depth/000000.png", lambda image: image + np.uint16(200)),
        "bop poses on images, kitti and bop images",
    ),
    "grey mask": (
        edit_image(BOP / "mask_visib/000000_000001.png", set_pixel(128)),
        "bop masks, bop poses on images",
    ),
    "wrong count": (edit_json(INFO, lambda d: d["0"][1].update(px_count_valid=1)), "bop masks"),
    "unknown instance": (
        edit_json(INFO, lambda d: d["0"][1].update(instance_id=77)),
        "bop tables, kitti and bop labels",
    ),
    "camera of one pixel": (edit_json("bop/camera.json", lambda d: d.update(fx=1.0)), "bop cameras"),
    "lens that the recipe does not have": (
        edit_json(CAMERA, flat("0", **LENS)),
        "bop cameras, bop poses on images",
    ),
    "sweep too many": (copy(POINTS, KITTI / "velodyne/000009.bin"), "kitti files"),
    "label too many": (copy(LABEL, KITTI / "label_2/000001.txt"), LABEL_READERS),
    "two blanks": (edit_text(LABEL, " ", "  "), LABEL_READERS),
    "empty label file": (lambda root: (root / LABEL).write_text(""), LABEL_READERS),
    "wrong height": (edit_text(LABEL, " 0.144000 ", " 0.154000 "), "kitti labels"),
    "wrong class": (edit_text(LABEL, "pallet", "carton"), "kitti labels"),
    "box beyond the image": (
        edit_text(LABEL, " 57.00 ", " -57.00 "),
        "kitti labels, kitti labels on images, kitti and bop labels",
    ),
    "six calib lines": (
        edit_text(CALIB, "Tr_imu_to_velo: ", ""),
        "kitti calib",
    ),
    "rotated LiDAR": (
        edit_text(CALIB, "Tr_velo_to_cam: 0.0", "Tr_velo_to_cam: 0.3"),
        "kitti calib, kitti labels on images, kitti points in boxes, kitti points on depth",
    ),
    "P1 of another camera": (edit_text(CALIB, "P1: 1", "P1: 9"), "kitti calib"),
    "floor too low": (
        edit_text(KITTI / "planes/000000.txt", "9.000000000e-01", "9.500000000e-01"),
        "kitti calib",
    ),
    "one point less": (
        edit_points(POINTS, "<f4", lambda points: points[:-4]),
        "kitti points in boxes, kitti points on depth, kitti sweeps",
    ),
    "nameless point": (edit_points(IDS, "<i4", lambda ids: ids + 1000), "kitti sweeps"),
    "ids all zero": (edit_points(IDS, "<i4", np.zeros_like), "kitti sweeps"),
    "one time less": (
        edit_points(BEAMS, "<f4", lambda beams: beams[:-1]),
        "kitti sweeps, kitti points in boxes, kitti points on depth",
    ),
    "half a ring": (
        edit_points(BEAMS, "<f4", lambda beams: beams + np.float32(0.5)),
        "kitti sweeps, kitti points in boxes",
    ),
    "beams all zero": (edit_points(BEAMS, "<f4", np.zeros_like), "kitti sweeps"),
    "rings upside down": (edit_points(BEAMS, "<f4", upside_down), "kitti sweeps"),
    "unknown format": (edit_json("manifest.json", lambda d: d["formats"].append("cacao")), "manifest"),
    "unknown target": (edit_json("manifest.json", lambda d: d["targets"].append("unicorn")), "manifest"),
    "targets of other objects": (edit_json("manifest.json", lambda d: d.update(targets=["carton"])), "manifest"),
    "empty recipe": (edit_json("manifest.json", lambda d: d.update(recipe={})), "manifest"),
    "no pockets": (edit_json("objects.json", flat("1", pockets=[])), "objects"),
    "one pocket less": (edit_json("objects.json", lambda d: drop_last(d["1"]["pockets"])), "objects"),
    "pocket on another face": (
        edit_json("objects.json", lambda d: d["1"]["pockets"][0].update(face="+x")),
        "objects",
    ),
    "pockets through the skids": (pockets_of([0.8, 0.9, 0.104]), "objects"),
    "pocket as high as a door": (pockets_of([0.8, 0.8, 2.0]), "objects"),
    "8-bit depth": (
        edit_image(KITTI / "depth_2/000000.png", lambda image: image.astype(np.uint8)),
        "kitti images, kitti points on depth, kitti and bop images",
    ),
    "no reading": (edit_image(KITTI / "depth_2/000000.png", black), "kitti images, kitti and bop images"),
}
"""Those that ``faults`` does not plant: the defect, and all checks that find it."""


@pytest.mark.parametrize("name", DEFECTS)
def test_defect_is_found_by_its_check(toy_copy: Path, name: str) -> None:
    defect, expected = DEFECTS[name]
    defect(toy_copy)
    assert failed(validate(toy_copy)) == set(expected.split(", "))


def test_every_check_has_a_defect_that_it_finds() -> None:
    found = {name for _, expected in DEFECTS.values() for name in expected.split(", ")}
    planted_elsewhere = {"bop exact images"}  # the toy holds none: tests/generation/test_exact_images.py
    assert found | {fault.check for fault in FAULTS} | planted_elsewhere >= set(CHECKS)


def test_incomplete_dataset_is_one_failed_check(toy_copy: Path) -> None:
    (toy_copy / "manifest.json").rename(toy_copy / "manifest.unfinished.json")
    (check,) = validate(toy_copy)
    assert (check.name, check.ok) == ("manifest", False)
    assert "the dataset is incomplete; resume it with" in check.detail


def test_detail_names_the_file_and_counts_the_rest(toy_copy: Path) -> None:
    for name in ("000000", "000002"):
        (toy_copy / KITTI / "velodyne_ids" / f"{name}.bin").unlink()
    detail = {check.name: check.detail for check in validate(toy_copy)}["kitti files"]
    assert detail == f"{toy_copy / KITTI}/velodyne_ids/000000.bin: this file is missing (and 1 more)"


SAY_NOTHING_OF_DATA = {".md", ".jpg", ".yaml", ""}
"""Endings of what only people read, and of SHA256SUMS, without which meshes are read unchecked."""


def test_a_missing_file_of_any_kind_is_noticed(tmp_path: Path) -> None:
    root = make_dataset(tmp_path / "data", make_manifest(1))
    files = sorted(path for path in root.rglob("*") if path.is_file() and path.suffix not in SAY_NOTHING_OF_DATA)
    # One of each kind, whatever its split and numbers.
    kinds = {re.sub(r"/(train|val|test)/|\d+", "#", str(path.relative_to(root))): path for path in files}
    assert len(kinds) > 25
    for kind, path in kinds.items():
        away = path.rename(tmp_path / "away")
        assert any(not check.ok for check in validate(root)), kind
        away.rename(path)
