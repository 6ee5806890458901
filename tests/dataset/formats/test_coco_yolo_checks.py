"""``validate`` finds what is wrong with COCO and YOLO files."""

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.dataset.defects import black, edit_image, edit_json, edit_text, remove
from tests.dataset.toy import failures, make_dataset, make_manifest
from warehouse_sim.dataset.validate import validate

TABLES = "coco/annotations"
CHECKS = {"coco files", "coco instances", "coco panoptic", "coco and bop masks"}
CHECKS |= {"yolo files", "yolo labels", "yolo and bop boxes"}


def first(change: Callable) -> Callable:
    return lambda data: change(data["annotations"][0])


def test_a_sound_dataset_passes(images_root: Path) -> None:
    checks = {check.name: check for check in validate(images_root)}
    assert set(checks) >= CHECKS
    assert [check for check in checks.values() if not check.ok] == []
    assert checks["coco and bop masks"].detail == "18 masks"


@pytest.mark.parametrize("formats", [("coco",), ("yolo",)])
def test_one_format_alone_is_checked(tmp_path: Path, formats: tuple[str, ...]) -> None:
    checks = validate(make_dataset(tmp_path / "data", make_manifest(formats=formats)))
    assert all(check.ok for check in checks), checks
    assert sum(check.name.startswith(formats[0]) for check in checks) >= 2


@pytest.mark.parametrize(
    ("defect", "expected"),
    [
        (remove("coco/train/000000_000000.png"), {"coco files"}),
        (remove(f"{TABLES}/panoptic_train/000000_000000.png"), {"coco files", "coco panoptic"}),
        (edit_json(f"{TABLES}/instances_train.json", first(lambda row: row.update(area=5))), {"coco instances"}),
        (edit_json(f"{TABLES}/instances_train.json", first(lambda row: row["bbox"].reverse())), {"coco instances"}),
        (edit_json(f"{TABLES}/instances_train.json", first(lambda row: row.update(iscrowd=1))), {"coco instances"}),
        (edit_json(f"{TABLES}/instances_train.json", first(lambda row: row.update(id=0))), {"coco instances"}),
        (
            edit_json(
                f"{TABLES}/instances_train.json", first(lambda row: row["T_camera_object"][0].__setitem__(3, 9.0))
            ),
            {"coco instances"},
        ),
        (
            edit_json(f"{TABLES}/instances_train.json", first(lambda row: row["segmentation"].update(counts="0"))),
            {"coco instances", "coco panoptic", "coco and bop masks"},
        ),
        (
            edit_json(f"{TABLES}/panoptic_train.json", lambda d: d["annotations"][0]["segments_info"].pop()),
            {"coco panoptic"},
        ),
        (edit_image(f"{TABLES}/panoptic_train/000000_000000.png", black), {"coco panoptic"}),
        (remove("yolo/obb/labels/train/000000_000000.txt"), {"yolo files", "yolo labels"}),
        (edit_text("yolo/segment/labels/train/000000_000000.txt", "0 0.", "0 1."), {"yolo labels"}),
        (
            edit_text("yolo/detect/labels/train/000000_000000.txt", "0 0.", "1 0."),
            {"yolo labels", "yolo and bop boxes"},
        ),
        (edit_text("yolo/detect/labels/train/000000_000000.txt", "0 0.", "0 0.0"), {"yolo and bop boxes"}),
        (edit_text("yolo/pose/data.yaml", "pallet", "carton"), {"yolo labels"}),
    ],
)
def test_a_defect_is_found_by_its_check(
    images_root: Path, tmp_path: Path, defect: Callable, expected: set[str]
) -> None:
    root = Path(shutil.copytree(images_root, tmp_path / "copy"))
    defect(root)
    assert set(failures(root)) == expected
