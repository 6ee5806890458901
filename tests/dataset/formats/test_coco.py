"""What COCO's own tools, and plain numpy, read from a toy dataset whose every pixel is known."""

import contextlib
import io
import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from pycocotools import mask as coco_mask
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

from tests.dataset.toy import CAMERA, PALLET, make_manifest, make_scene, observe, write_scene
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.boxes import mask_box_xyxy

SPLITS = {"train": (0,), "val": (1,), "test": (2,)}


def load(root: Path, name: str, split: str) -> COCO:
    with contextlib.redirect_stdout(io.StringIO()):
        return COCO(str(root / "coco" / "annotations" / f"{name}_{split}.json"))


def seen_targets(scene: int, observation: int) -> list:
    return [item for item in observe(make_scene(scene))[observation].annotations if item.pixels_visible]


@pytest.mark.parametrize("split", SPLITS)
def test_instances_are_the_visible_pixels(images_root: Path, split: str) -> None:
    coco, (scene,) = load(images_root, "instances", split), SPLITS[split]
    assert sorted(coco.imgs) == [2 * scene, 2 * scene + 1]
    found = 0
    for image in coco.imgs.values():
        ids = observe(make_scene(scene))[image["observation"]].buffers.instance_mask
        rows, targets = coco.imgToAnns[image["id"]], seen_targets(scene, image["observation"])
        assert [row["instance_id"] for row in rows] == [item.instance_id for item in targets]
        for row, target in zip(rows, targets, strict=True):
            mask = coco.annToMask(row).astype(bool)
            assert np.array_equal(mask, ids == target.instance_id)
            assert row["area"] == mask.sum() == coco_mask.area(row["segmentation"])
            assert row["bbox"] == coco_mask.toBbox(row["segmentation"]).tolist()
            assert row["iscrowd"] == row["ignore"] == (target.visible_fraction < 0.1)
            assert np.array_equal(row["T_camera_object"], target.T_camera_object)
            assert coco.cats[row["category_id"]]["name"] == "pallet"
            found += 1
    assert found >= 2


def test_amodal_masks_are_cut_at_the_image_and_the_uncut_box_is_told(images_root: Path) -> None:
    amodal, instances = load(images_root, "instances_amodal", "train"), load(images_root, "instances", "train")
    assert sorted(amodal.anns) == sorted(instances.anns)
    left_the_image = hidden = 0
    for number, row in amodal.anns.items():
        image = amodal.imgs[row["image_id"]]
        target = next(item for item in seen_targets(0, image["observation"]) if item.instance_id == row["instance_id"])
        canvas = np.zeros((3 * CAMERA.height, 3 * CAMERA.width), dtype=bool)
        x, y = target.amodal_mask_offset[0] + CAMERA.width, target.amodal_mask_offset[1] + CAMERA.height
        canvas[y : y + target.amodal_mask.shape[0], x : x + target.amodal_mask.shape[1]] = target.amodal_mask
        whole = canvas[CAMERA.height : 2 * CAMERA.height, CAMERA.width : 2 * CAMERA.width]
        mask = amodal.annToMask(row).astype(bool)
        assert np.array_equal(mask, whole)
        assert row["area"] == whole.sum()
        assert row["bbox"] == coco_mask.toBbox(row["segmentation"]).tolist()
        left, top, right, bottom = mask_box_xyxy(canvas)
        uncut = [left - CAMERA.width, top - CAMERA.height, right - left + 1, bottom - top + 1]
        assert row["bbox_uncut"] == uncut
        left_the_image += uncut != row["bbox"]
        visible = instances.annToMask(instances.anns[number]).astype(bool)
        assert not (visible & ~mask).any()
        hidden += bool((mask & ~visible).any())
    assert left_the_image
    assert hidden


@pytest.mark.parametrize("split", SPLITS)
def test_panoptic_images_name_every_pixel(images_root: Path, split: str) -> None:
    path, (scene,) = images_root / "coco" / "annotations" / f"panoptic_{split}.json", SPLITS[split]
    data = json.loads(path.read_text())
    categories = {item["id"]: item for item in data["categories"]}
    assert [row["image_id"] for row in data["annotations"]] == [image["id"] for image in data["images"]]
    for row, image, seen in zip(data["annotations"], data["images"], observe(make_scene(scene)), strict=True):
        bgr = cv2.imread(str(path.with_suffix("") / row["file_name"])).astype(int)
        number = bgr[..., 2] + 256 * bgr[..., 1] + 65536 * bgr[..., 0]
        gt = seen.buffers.instance_mask
        # The floor is stuff and the only one; all else are things with ids of their own.
        assert np.array_equal(number, gt)
        assert {item["id"] for item in row["segments_info"]} == set(np.unique(gt)) - {0}
        for item in row["segments_info"]:
            mask = gt == item["id"]
            left, top, right, bottom = mask_box_xyxy(mask)
            assert item["area"] == mask.sum()
            assert item["bbox"] == [left, top, right - left + 1, bottom - top + 1]
            category = categories[item["category_id"]]
            expected = {1: "floor", 20: "carton"}.get(item["id"], "pallet")
            assert (category["name"], category["isthing"]) == (expected, expected != "floor")
        assert (image["width"], image["height"]) == (CAMERA.width, CAMERA.height)


def test_numbers_of_annotations_are_unique_in_the_dataset_and_begin_with_one(images_root: Path) -> None:
    numbers = [number for split in SPLITS for number in load(images_root, "instances", split).anns]
    assert numbers == list(range(1, len(numbers) + 1))


def test_the_ground_truth_scores_one(images_root: Path) -> None:
    coco = load(images_root, "instances", "train")
    rows = [
        {key: row[key] for key in ("image_id", "category_id", "bbox", "segmentation")} | {"score": 1.0}
        for row in coco.anns.values()
        if not row["iscrowd"]
    ]
    for kind in ("bbox", "segm"):
        with contextlib.redirect_stdout(io.StringIO()):
            score = COCOeval(coco, coco.loadRes([dict(row) for row in rows]), kind)
            score.evaluate()
            score.accumulate()
            score.summarize()
        assert score.stats[0] == 1.0


def test_images_are_names_of_the_same_file(images_root: Path) -> None:
    image, other = images_root / "coco/train/000000_000001.png", images_root / "bop/train/000000/rgb/000001.png"
    assert image.stat().st_ino == other.stat().st_ino


def test_the_same_bytes_in_any_order_and_after_an_interruption(images_root: Path, tmp_path: Path) -> None:
    manifest = make_manifest(formats=("coco", "bop"))
    store = DatasetStore(tmp_path / "data", manifest)
    store.begin([PALLET], CAMERA)
    write_scene(store, 2)
    # What a killed run leaves of scene 0.
    (tmp_path / "data/coco/parts/000000").mkdir()
    (tmp_path / "data/coco/parts/000000/instances.json").write_text("[")
    (tmp_path / "data/coco/train/000000_000001.png").write_bytes(b"")
    for index in (0, 1):
        write_scene(store, index)
    store.finish()
    names = sorted(path.relative_to(images_root) for path in (images_root / "coco").rglob("*") if path.is_file())
    assert names == sorted(path.relative_to(tmp_path / "data") for path in (tmp_path / "data/coco").rglob("*.*"))
    for name in names:
        assert (tmp_path / "data" / name).read_bytes() == (images_root / name).read_bytes(), name


def test_a_missing_part_of_a_scene_is_named(tmp_path: Path) -> None:
    manifest = make_manifest(formats=("coco",))
    store = DatasetStore(tmp_path / "data", manifest)
    store.begin([PALLET], CAMERA)
    for index in range(3):
        write_scene(store, index)
    (tmp_path / "data/coco/parts/000001/panoptic.json").unlink()
    with pytest.raises(DatasetError, match=r"000001/panoptic.json: is missing; remove the record of scene 1"):
        store.finish()
