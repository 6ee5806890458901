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
    blank_line,
    copy,
    drop_last,
    edit_image,
    edit_json,
    edit_points,
    edit_runs,
    edit_text,
    flip,
    move_pose,
    quarter_turns,
    remove,
    set_pixel,
    shift,
    turn_symmetry,
    upside_down,
)
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
    "kitti and bop cameras",
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


LABEL_READERS = {"kitti labels", "kitti labels on images", "kitti points in boxes", "kitti and bop labels"}
DEFECTS: list[tuple[str, Callable[[Path], object], set[str]]] = [
    ("symmetry is no group", edit_json("objects.json", lambda d: turn_symmetry(d["1"])), {"objects", "bop models"}),
    (
        "diameter differs",
        edit_json("bop/models_eval/models_info.json", lambda d: d["1"].update(diameter=9.0)),
        {"bop models"},
    ),
    (
        "model size differs",
        edit_json("bop/models/models_info.json", lambda d: d["1"].update(size_x=9.0)),
        {"bop models"},
    ),
    (
        "symmetry not in BOP",
        edit_json("bop/models/models_info.json", lambda d: d["1"].pop("symmetries_discrete")),
        {"bop models"},
    ),
    ("mesh missing", remove("bop/models_eval/obj_000001.ply"), {"objects", "bop models"}),
    ("record of another split", edit_json("scenes/000001.json", lambda d: d.update(split="test")), {"scene records"}),
    ("record too many", copy("scenes/000001.json", "scenes/000003.json"), {"scene records"}),
    (
        "instance twice",
        edit_json("scenes/000001.json", lambda d: d["objects"].append(d["objects"][0])),
        {"scene records"},
    ),
    ("mask missing", remove(BOP / "mask/000000_000001.png"), {"bop files", "bop masks", "bop poses on images"}),
    ("image too many", copy(BOP / "rgb/000000.png", BOP / "rgb/000007.png"), {"bop files"}),
    ("scene in two splits", lambda root: shutil.copytree(root / BOP, root / "bop/test/000000"), {"bop files"}),
    (
        "camera row missing",
        edit_json(BOP / "scene_camera.json", lambda d: d.pop("1")),
        {
            "bop tables",
            "bop cameras",
            "bop coco",
            "bop images",
            "bop masks",
            "bop poses on images",
            "kitti and bop labels",
            "kitti and bop cameras",
            "kitti and bop images",
        },
    ),
    (
        "mirrored pose",
        edit_json(BOP / "scene_gt.json", lambda d: d["0"][0].update(cam_R_m2c=[1, 0, 0, 0, 1, 0, 0, 0, -1])),
        {
            "bop tables",
            "bop cameras",
            "bop coco",
            "bop images",
            "bop masks",
            "bop poses on images",
            "kitti and bop labels",
            "kitti and bop cameras",
            "kitti and bop images",
        },
    ),
    (
        "pose moved by 1 mm",
        edit_json(BOP / "scene_gt.json", lambda d: shift(d["0"][1]["cam_t_m2c"], 1.0)),
        {"bop tables", "kitti and bop labels"},
    ),
    (
        "pose moved by 40 mm everywhere in BOP",
        move_pose(40.0),
        {"scene records", "bop poses on images", "kitti labels", "kitti and bop labels"},
    ),
    (
        "wrong COCO area",
        edit_json(BOP / "scene_gt_coco.json", lambda d: d["annotations"][0].update(area=3)),
        {"bop coco"},
    ),
    (
        "wrong COCO box",
        edit_json(BOP / "scene_gt_coco.json", lambda d: shift(d["annotations"][2]["bbox"], 1)),
        {"bop coco"},
    ),
    (
        "COCO file outside",
        edit_json(BOP / "scene_gt_coco.json", lambda d: d["images"][0].update(file_name="../../x.png")),
        {"bop coco"},
    ),
    (
        "COCO mask of another object",
        edit_json(
            BOP / "scene_gt_coco.json",
            lambda d: d["annotations"][0].update(segmentation=d["annotations"][1]["segmentation"]),
        ),
        {"bop masks"},
    ),
    ("COCO runs without the closing change", edit_runs(lambda counts: [*counts[:-2], sum(counts[-2:])]), {"bop masks"}),
    ("COCO runs beyond the image", edit_runs(lambda counts: [*counts, 9]), {"bop masks"}),
    ("COCO runs too few", edit_runs(lambda counts: counts[:-1]), {"bop masks"}),
    ("COCO run below zero", edit_runs(lambda counts: [counts[0] + 5, -5, *counts[1:]]), {"bop masks"}),
    ("COCO runs in words", edit_runs(lambda counts: "many"), {"bop masks"}),
    ("target missing", edit_json("bop/test_targets_bop19.json", drop_last), {"bop targets"}),
    ("image missing in targets", edit_json("bop/test_targets_bop24.json", drop_last), {"bop targets"}),
    ("black image", edit_image(BOP / "rgb/000000.png", black), {"bop images", "kitti and bop images"}),
    (
        "depth 20 cm off",
        edit_image(BOP / "depth/000000.png", lambda image: image + np.uint16(200)),
        {"bop poses on images", "kitti and bop images"},
    ),
    (
        "visible mask beyond its amodal mask",
        edit_image(BOP / "mask_visib/000000_000001.png", set_pixel(255)),
        {"bop masks"},
    ),
    (
        "grey mask",
        edit_image(BOP / "mask_visib/000000_000001.png", set_pixel(128)),
        {"bop masks", "bop poses on images"},
    ),
    (
        "masks exchanged",
        copy(BOP / "mask_visib/000000_000000.png", BOP / "mask_visib/000000_000001.png"),
        {"bop masks"},
    ),
    ("wrong count", edit_json(BOP / "scene_gt_info.json", lambda d: d["0"][1].update(px_count_valid=1)), {"bop masks"}),
    (
        "wrong fraction",
        edit_json(BOP / "scene_gt_info.json", lambda d: d["0"][1].update(visib_fract=0.5)),
        {"bop tables", "bop masks"},
    ),
    (
        "unknown instance",
        edit_json(BOP / "scene_gt_info.json", lambda d: d["0"][1].update(instance_id=77)),
        {"bop tables", "kitti and bop labels"},
    ),
    ("frame missing", remove(KITTI / "planes/000002.txt"), {"kitti files", "kitti calib"}),
    ("test frame in train", edit_text("kitti/ImageSets/train.txt", "000001", "000004"), {"kitti files"}),
    ("sweep too many", copy(KITTI / "velodyne/000000.bin", KITTI / "velodyne/000009.bin"), {"kitti files"}),
    (
        "label too many",
        copy(KITTI / "label_2/000000.txt", KITTI / "label_2/000001.txt"),
        LABEL_READERS,
    ),
    (
        "occluded as float",
        edit_text(KITTI / "label_2/000000.txt", " 1 ", " 1.0 "),
        LABEL_READERS,
    ),
    ("two blanks", edit_text(KITTI / "label_2/000000.txt", " ", "  "), LABEL_READERS),
    ("blank line at the end", blank_line, LABEL_READERS),
    ("empty label file", lambda root: (root / KITTI / "label_2/000001.txt").write_text(""), LABEL_READERS),
    (
        "wrong height",
        edit_text(KITTI / "label_2/000000.txt", " 0.144000 ", " 0.154000 "),
        {"kitti labels", "kitti and bop labels"},
    ),
    (
        "wrong class",
        edit_text(KITTI / "label_2/000000.txt", "pallet", "carton"),
        {"kitti labels", "kitti and bop labels"},
    ),
    (
        "box beyond the image",
        edit_text(KITTI / "label_2/000000.txt", " 57.00 ", " -57.00 "),
        {"kitti labels", "kitti labels on images", "kitti and bop labels"},
    ),
    (
        "six calib lines",
        edit_text(KITTI / "calib/000000.txt", "Tr_imu_to_velo: ", ""),
        {
            "kitti calib",
            "kitti labels on images",
            "kitti points in boxes",
            "kitti points on depth",
            "kitti and bop cameras",
        },
    ),
    (
        "lens that the recipe does not have",
        edit_json(BOP / "scene_camera.json", lambda d: d["0"].update(cam_distortion=[-0.2, 0.05, 0, 0, 0])),
        {"bop cameras", "bop poses on images", "kitti and bop cameras"},
    ),
    (
        "rotated LiDAR",
        edit_text(KITTI / "calib/000000.txt", "Tr_velo_to_cam: 0.0", "Tr_velo_to_cam: 0.3"),
        {"kitti calib", "kitti points in boxes"},
    ),
    (
        "LiDAR elsewhere",
        edit_text(KITTI / "calib/000000.txt", "-2.700000000000e-01", "7.000000000000e-01"),
        {"kitti points in boxes"},
    ),
    ("P1 of another camera", edit_text(KITTI / "calib/000000.txt", "P1: 1", "P1: 9"), {"kitti calib"}),
    ("floor too low", edit_text(KITTI / "planes/000000.txt", "9.000000000e-01", "9.500000000e-01"), {"kitti calib"}),
    (
        "points in mm",
        edit_points(KITTI / "velodyne/000000.bin", "<f4", lambda points: points * 1000),
        {"kitti points in boxes", "kitti points on depth", "kitti sweeps"},
    ),
    (
        "one point less",
        edit_points(KITTI / "velodyne/000000.bin", "<f4", lambda points: points[:-4]),
        {"kitti points in boxes", "kitti points on depth", "kitti sweeps"},
    ),
    (
        "nameless point",
        edit_points(KITTI / "velodyne_ids/000000.bin", "<i4", lambda ids: ids + 1000),
        {"kitti sweeps"},
    ),
    (
        "one time less",
        edit_points(KITTI / "velodyne_beams/000000.bin", "<f4", lambda beams: beams[:-1]),
        {"kitti sweeps", "kitti points in boxes"},
    ),
    (
        "half a ring",
        edit_points(KITTI / "velodyne_beams/000000.bin", "<f4", lambda beams: beams + np.float32(0.5)),
        {"kitti sweeps", "kitti points in boxes"},
    ),
    ("beams all zero", edit_points(KITTI / "velodyne_beams/000000.bin", "<f4", np.zeros_like), {"kitti sweeps"}),
    ("ids all zero", edit_points(KITTI / "velodyne_ids/000000.bin", "<i4", np.zeros_like), {"kitti sweeps"}),
    (
        "rings upside down",
        edit_points(KITTI / "velodyne_beams/000000.bin", "<f4", lambda beams: upside_down(beams)),
        {"kitti sweeps"},
    ),
    ("unknown format", edit_json("manifest.json", lambda d: d["formats"].append("cacao")), {"manifest"}),
    ("unknown target", edit_json("manifest.json", lambda d: d["targets"].append("unicorn")), {"manifest"}),
    ("targets of other objects", edit_json("manifest.json", lambda d: d.update(targets=["carton"])), {"manifest"}),
    ("empty recipe", edit_json("manifest.json", lambda d: d.update(recipe={})), {"manifest"}),
    (
        "split table of other scenes",
        edit_json("manifest.json", lambda d: d["split_table"]["train"].update(targets=7)),
        {"manifest"},
    ),
    ("no pockets", edit_json("objects.json", lambda d: d["1"].update(pockets=[])), {"objects"}),
    ("one pocket less", edit_json("objects.json", lambda d: drop_last(d["1"]["pockets"])), {"objects"}),
    (
        "pocket on another face",
        edit_json("objects.json", lambda d: d["1"]["pockets"][0].update(face="+x")),
        {"objects"},
    ),
    (
        "pockets through the skids",
        edit_json("objects.json", lambda d: [p.update(size=[0.8, 0.9, 0.104]) for p in d["1"]["pockets"]]),
        {"objects"},
    ),
    (
        "pocket as high as a door",
        edit_json("objects.json", lambda d: [p.update(size=[0.8, 0.8, 2.0]) for p in d["1"]["pockets"]]),
        {"objects"},
    ),
    ("false symmetry", quarter_turns, {"objects"}),
    (
        "diameter a little off",
        edit_json("objects.json", lambda d: d["1"].update(diameter=1.42)),
        {"objects", "bop models"},
    ),
    ("flipped byte of a mesh", flip("bop/models_eval/obj_000001.ply", -9, 1), {"objects", "bop models"}),
    ("camera of one pixel", edit_json("bop/camera.json", lambda d: d.update(fx=1.0)), {"bop cameras"}),
    (
        "another camera in one image",
        edit_json(BOP / "scene_camera.json", lambda d: d["0"].update(depth_scale=0.1)),
        {"bop cameras", "bop poses on images", "kitti and bop images"},
    ),
    (
        "8-bit depth",
        edit_image(KITTI / "depth_2/000000.png", lambda image: image.astype(np.uint8)),
        {"kitti images", "kitti points on depth", "kitti and bop images"},
    ),
    ("no reading", edit_image(KITTI / "depth_2/000000.png", black), {"kitti images", "kitti and bop images"}),
]


@pytest.mark.parametrize(("defect", "expected"), [row[1:] for row in DEFECTS], ids=[row[0] for row in DEFECTS])
def test_defect_is_found_by_its_check(toy_copy: Path, defect: Callable[[Path], object], expected: set[str]) -> None:
    defect(toy_copy)
    assert failed(validate(toy_copy)) == expected


def test_every_check_has_a_defect_that_it_finds() -> None:
    assert set().union(*(row[2] for row in DEFECTS)) | {"manifest"} == set(CHECKS)


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


def test_a_missing_file_of_any_kind_is_noticed(toy_copy: Path, tmp_path: Path) -> None:
    files = sorted(path for path in toy_copy.rglob("*") if path.is_file() and path.suffix not in SAY_NOTHING_OF_DATA)
    # One of each kind, whatever its split and numbers.
    kinds = {re.sub(r"/(train|val|test)/|\d+", "#", str(path.relative_to(toy_copy))): path for path in files}
    assert len(kinds) > 25
    for kind, path in kinds.items():
        away = path.rename(tmp_path / "away")
        assert any(not check.ok for check in validate(toy_copy)), kind
        away.rename(path)
