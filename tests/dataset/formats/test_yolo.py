"""YOLO's label files of a toy dataset, read here as its tools read them."""

from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from tests.dataset.toy import CAMERA, make_manifest, make_scene, observe
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.boxes import mask_box_xyxy

SIZE_WH = np.array([CAMERA.width, CAMERA.height])


def rows_of(root: Path, task: str, observation: int = 0) -> list[np.ndarray]:
    path = root / f"yolo/{task}/labels/train/000000_{observation:06d}.txt"
    return [np.array(line.split(), dtype=float) for line in path.read_text().splitlines()]


def seen_masks() -> list[np.ndarray]:
    seen = observe(make_scene(0))[0]
    return [seen.buffers.instance_mask == item.instance_id for item in seen.annotations if item.pixels_visible]


def test_boxes_are_those_of_the_visible_pixels(images_root: Path) -> None:
    rows = rows_of(images_root, "detect")
    assert len(rows) == len(seen_masks()) >= 2
    for row, mask in zip(rows, seen_masks(), strict=True):
        left, top, right, bottom = mask_box_xyxy(mask)
        centre, size = row[1:3] * SIZE_WH, row[3:] * SIZE_WH
        np.testing.assert_allclose(
            np.concatenate([centre - size / 2, centre + size / 2]), [left, top, right + 1, bottom + 1], atol=1e-4
        )
        assert row[0] == 0


def test_polygons_fill_to_the_visible_masks(images_root: Path) -> None:
    for row, mask in zip(rows_of(images_root, "segment"), seen_masks(), strict=True):
        image = np.zeros(mask.shape, dtype=np.uint8)
        cv2.fillPoly(image, [(row[1:].reshape(-1, 2).astype(np.float32) * SIZE_WH).astype(np.int32)], 1)
        parts = cv2.connectedComponents(mask.astype(np.uint8), connectivity=8)[0] - 1
        assert not (mask & (image == 0)).any()
        assert np.array_equal(image, mask) or parts > 1


def test_key_points_lie_where_the_pocket_is(images_root: Path) -> None:
    data = yaml.safe_load((images_root / "yolo/pose/data.yaml").read_text())
    # The toy pallet has one pocket a side.
    assert (data["kpt_shape"], data["flip_idx"]) == ([4, 3], [1, 0, 3, 2])
    seen = observe(make_scene(0))[0]
    (first, *_), row = (item for item in seen.annotations if item.pixels_visible), rows_of(images_root, "pose")[0]
    pocket = first.T_camera_object @ np.array(
        [[0.4, -0.4, -0.4, 0.4], [0.4] * 4, [0.032, 0.032, -0.072, -0.072], [1] * 4]
    )
    other = first.T_camera_object @ np.array(
        [[-0.4, 0.4, 0.4, -0.4], [-0.4] * 4, [0.032, 0.032, -0.072, -0.072], [1] * 4]
    )
    points = row[5:].reshape(4, 3)
    shown = points[:, 2] > 0
    assert shown.any()
    expected = [CAMERA.project(item[:3].T) for item in (pocket, other)]
    found = points[:, :2] * SIZE_WH - 0.5
    assert min(np.abs(found - item)[shown].max() for item in expected) < 1e-3


@pytest.mark.parametrize("task", ["detect", "segment", "pose", "obb"])
def test_traps_of_the_tools(images_root: Path, task: str) -> None:
    folder = images_root / "yolo" / task
    data = yaml.safe_load((folder / "data.yaml").read_text())
    assert data["names"] == {0: "pallet"}
    assert "path" not in data
    columns = {"detect": 5, "pose": 5 + 4 * 3, "obb": 9}.get(task)
    for split in ("train", "val", "test"):
        images = sorted((folder / data[split]).iterdir())
        assert [path.stem for path in images] == [path.stem for path in sorted((folder / "labels" / split).iterdir())]
        for image in images:
            head, tail = str(image).rsplit("/images/", 1)
            lines = Path(f"{head}/labels/{tail}").with_suffix(".txt").read_text().splitlines()
            assert len(set(lines)) == len(lines)
            for line in lines:
                row = np.array(line.split(), dtype=float)
                assert row.size == columns or (columns is None and row.size >= 7 and row.size % 2)
                fractions = row[1:5] if task == "pose" else row[1:]
                assert fractions.min() >= 0.0
                assert fractions.max() <= 1.0
    assert not [path for path in (images_root / "yolo").rglob("masks")]
    assert (folder / "labels/train/000000_000001.txt").read_bytes() == b""


def test_images_are_names_of_one_file(images_root: Path) -> None:
    inodes = {
        (images_root / f"yolo/{task}/images/train/000000_000000.png").stat().st_ino
        for task in ("detect", "segment", "pose", "obb")
    }
    assert inodes == {(images_root / "bop/train/000000/rgb/000000.png").stat().st_ino}


def test_a_class_that_is_no_target_is_named(tmp_path: Path) -> None:
    from dataclasses import replace

    from tests.dataset.toy import PALLET, write_scene

    store = DatasetStore(tmp_path / "data", replace(make_manifest(formats=("yolo",)), targets=("carton",)))
    store.begin([PALLET], CAMERA)
    with pytest.raises(DatasetError, match="class pallet is not among the dataset's targets carton"):
        write_scene(store, 0)
