"""Files of detections against pycocotools, which reads and draws them its own way."""

import contextlib
import io
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pycocotools import mask as coco_mask
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results.detections import FoundObject, read_labels, read_results, write_labels, write_results
from warehouse_sim.errors import DatasetError
from warehouse_sim.evaluation.detection.scores import Evaluated, score_detections, seen_by_class


def noisy(reader: DatasetReader, split: str, seed: int = 0) -> list[FoundObject]:
    """Return detections that are somewhat off, some twice, some missing."""
    rng, found = np.random.default_rng(seed), []
    for image in reader.images(split):
        for target in image.targets:
            if not target.pixels_visible:
                continue
            left, top, right, bottom = target.box_visible_xyxy
            mask = np.roll(reader.mask_visible(image, target.gt_index), int(rng.integers(3)), axis=1)
            edges = np.array([left, top, right + 1.0, bottom + 1.0]) + rng.normal(0, 1, 4)
            name = reader.objects[target.obj_id].class_name
            for _ in range(int(rng.integers(3))):
                box = tuple(float(value) for value in edges)
                kinds = {"epal1": 1.0 / 3.0, "of another dataset": 1.0} if len(found) % 2 else {}
                place = image.scene_id, image.image_id
                found.append(FoundObject(*place, float(rng.random()), name, None, box, mask, kinds))
    return found


def test_what_is_written_is_read(images_root: Path, tmp_path: Path) -> None:
    reader = DatasetReader(images_root)
    found = noisy(reader, "train")
    write_results(tmp_path / "found.json", found, reader)
    again = read_results(tmp_path / "found.json", reader, "train")
    assert len(again) == len(found) > 3
    for a, b in zip(found, again, strict=True):
        assert (a.scene_id, a.image_id, a.score, a.class_name) == (b.scene_id, b.image_id, b.score, b.class_name)
        np.testing.assert_allclose(a.edges, b.edges)
        np.testing.assert_array_equal(a.mask, b.mask)
        assert a.kind_likelihood == b.kind_likelihood
    assert any(item.kind_likelihood for item in again)
    assert read_results(tmp_path / "found.json", reader, "test") == []


@pytest.mark.parametrize("kind", ["bbox", "segm"])
def test_pycocotools_reads_them_and_scores_alike(images_root: Path, tmp_path: Path, kind: str) -> None:
    reader = DatasetReader(images_root)
    for seed in range(3):
        found = noisy(reader, "train", seed)
        write_results(tmp_path / f"{seed}.json", found, reader)
        with contextlib.redirect_stdout(io.StringIO()):
            gt = COCO(str(images_root / "coco" / "annotations" / "instances_train.json"))
            evaluation = COCOeval(gt, gt.loadRes(str(tmp_path / f"{seed}.json")), kind)
            evaluation.params.catIds = [1]
            evaluation.evaluate()
            evaluation.accumulate()
        pallets = [item for item in found if item.class_name == "pallet"]
        # COCO requires what is at least a tenth visible, however small.
        scores = score_detections(pallets, reader, reader.images("train"), Evaluated(0.1, 0.0))
        mine = next(item for item in scores if item.class_name == "pallet").precision
        name = "box" if kind == "bbox" else "mask"
        for index, overlap in ((0, "_50"), (5, "_75")):
            precision = evaluation.eval["precision"][index, :, 0, 0, -1]
            assert mine[name + overlap] == pytest.approx(precision[precision > -1].mean(), abs=1e-6)


def test_ground_truth_scores_one_and_nothing_scores_nothing(images_root: Path) -> None:
    reader = DatasetReader(images_root)
    gt = [
        FoundObject(image.scene_id, image.image_id, 0.9, reader.objects[item.obj_id].class_name, None, None,
                    reader.mask_visible(image, item.gt_index))
        for image in reader.images("train") for item in image.targets if item.pixels_visible
    ]  # fmt: skip
    for row in score_detections(gt, reader, reader.images("train"), Evaluated(0.0, 0.0)):
        assert row.precision["box"] == row.precision["mask"] == row.panoptic_quality == pytest.approx(1.0)
    for row in score_detections([], reader, reader.images("train")):
        assert row.precision["box_50"] == 0.0
        assert row.wanted > 0


def test_panoptic_quality_by_hand(images_root: Path) -> None:
    """One of n masks found with an overlap of q, and one false: q / (1 + (n - 1 + 1) / 2)."""
    reader = DatasetReader(images_root)
    images = reader.images("train")
    wanted = [
        (i, t)
        for i in images
        for t in i.targets
        if Evaluated().takes(t) and reader.objects[t.obj_id].class_name == "pallet"
    ]
    image, target = max(wanted, key=lambda pair: pair[1].pixels_visible)
    mask = reader.mask_visible(image, target.gt_index).copy()
    size = mask.sum()
    rows = np.argwhere(mask)[: size // 5]
    mask[tuple(rows.T)] = False
    false = np.zeros_like(mask)
    false[:4, :4] = True
    found = [FoundObject(image.scene_id, image.image_id, 0.9, "pallet", mask=item) for item in (mask, false)]
    found[1:] = [FoundObject(image.scene_id, image.image_id, 0.8, "pallet", mask=false)]
    found.append(FoundObject(image.scene_id, image.image_id, 0.2, "pallet", mask=false))
    row = next(r for r in score_detections(found, reader, [image], Evaluated()) if r.class_name == "pallet")
    n = sum(1 for i, _ in wanted if i is image)
    assert row.panoptic_quality == pytest.approx(mask.sum() / size / (1 + (n - 1 + 1) / 2))


def test_what_no_depth_was_read_of_is_not_to_be_found(images_root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Depth that ends in the middle of a mask measures half of it, give or take a column."""
    reader = DatasetReader(images_root)
    image, target = max(
        ((i, t) for i in reader.images("train") for t in i.targets if reader.objects[t.obj_id].class_name == "pallet"),
        key=lambda pair: pair[1].pixels_visible,
    )
    mask = reader.mask_visible(image, target.gt_index)
    columns = np.sort(np.nonzero(mask)[1])
    for fraction, is_wanted in ((0.45, False), (0.55, True)):
        depth = np.ones(mask.shape, np.float32)
        depth[:, columns[round(fraction * len(columns))] :] = 0.0
        monkeypatch.setattr(reader, "depth", lambda image, depth=depth: depth)
        alone = replace(image, targets=(target,))
        (seen,) = seen_by_class([], reader, [alone], Evaluated(0.0, 0.0, measured=0.5))["pallet"]
        assert seen.wanted.tolist() == [is_wanted], fraction


def test_boxes_of_bop_and_of_any_tool_are_taken(images_root: Path, tmp_path: Path) -> None:
    reader = DatasetReader(images_root)
    image = reader.images("train")[0]
    bop = [
        {"scene_id": image.scene_id, "image_id": image.image_id, "category_id": 1, "score": 0.5, "bbox": [3, 4, 10, 5]}
    ]
    (tmp_path / "bop.json").write_text(json.dumps(bop))
    (found,) = read_results(tmp_path / "bop.json", reader, "train")
    assert (found.model, found.class_name, found.edges) == (1, "", (3.0, 4.0, 13.0, 9.0))
    mask = np.zeros((image.camera.height, image.camera.width), dtype=np.uint8)
    mask[5:9, 20:40] = 1
    runs = coco_mask.encode(np.asfortranarray(mask))
    rows = [
        {
            "image_id": image.image_id,
            "category_id": 1,
            "score": 1,
            "segmentation": {"size": runs["size"], "counts": runs["counts"].decode()},
        }
    ]
    rows[0]["image_id"] = image.scene_id * reader.manifest.observations_per_scene + image.image_id
    (tmp_path / "coco.json").write_text(json.dumps(rows))
    (found,) = read_results(tmp_path / "coco.json", reader, "train")
    np.testing.assert_array_equal(found.mask, mask > 0)


def test_label_files_are_those_of_the_yolo_folder(images_root: Path, tmp_path: Path) -> None:
    reader = DatasetReader(images_root)
    gt = []
    for image in reader.images("train"):
        for item in image.targets:
            left, top, right, bottom = item.box_visible_xyxy
            name = reader.objects[item.obj_id].class_name
            edges = (left, top, right + 1.0, bottom + 1.0)
            gt.append(FoundObject(image.scene_id, image.image_id, 0.75, name, edges=edges))
    write_labels(tmp_path, gt, reader, "train")
    for path in (images_root / "yolo" / "detect" / "labels" / "train").glob("*.txt"):
        ours, theirs = (
            np.array([[float(word) for word in line.split()] for line in file.read_text().splitlines()])
            for file in (tmp_path / path.name, path)
        )
        if not theirs.size:
            assert not ours.size
            continue
        order = np.lexsort(theirs[:, 1:].T)
        np.testing.assert_allclose(ours[np.lexsort(ours[:, 1:5].T)][:, :5], theirs[order], atol=1e-5)
        assert (ours[:, 5] == 0.75).all()
    again = read_labels(tmp_path, reader, "train")
    assert len(again) == len(gt)
    np.testing.assert_allclose(sorted(item.edges for item in again), sorted(item.edges for item in gt), atol=1e-3)
    of_others = read_labels(images_root / "yolo" / "detect" / "labels" / "train", reader, "train")
    assert len(of_others) == len(gt)


BOX = {"image_id": 0, "category_id": 1, "score": 1, "bbox": [0, 0, 1, 1]}


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ({"image_id": 0}, "must be a list"),
        ([{"image_id": 10**6, "category_id": 1, "score": 1, "bbox": [0, 0, 1, 1]}], "has no image 1000000"),
        ([{"image_id": 0, "category_id": 77, "score": 1, "bbox": [0, 0, 1, 1]}], "category_id 77 is no class"),
        ([{"image_id": 0, "category_id": 1, "score": 2, "bbox": [0, 0, 1, 1]}], "score"),
        ([{"image_id": 0, "category_id": 1, "score": 1}], "neither a bbox"),
        ([{"image_id": 0, "category_id": 1, "score": 1, "bbox": [0, 0, 1]}], "4 numbers"),
        ([{"image_id": 0, "category_id": 1, "score": 1, "segmentation": {"size": [1, 1], "counts": [1]}}], "size"),
        ([{**BOX, "kind_likelihood": {"epal1": 1.5}}], "kind_likelihood: epal1 must be 0 to 1"),
        ([{**BOX, "kind_likelihood": {"epal1": True}}], "kind_likelihood: epal1 must be of type float"),
        ([{**BOX, "kind_likelihood": ["epal1"]}], "kind_likelihood must be of type dict"),
        ([7], "image_id"),
    ],
)
def test_hostile_files_are_rejected_in_one_line(images_root: Path, tmp_path: Path, rows: object, message: str) -> None:
    (tmp_path / "bad.json").write_text(json.dumps(rows))
    with pytest.raises(DatasetError, match=message):
        read_results(
            tmp_path / "bad.json", DatasetReader(images_root), DatasetReader(images_root).images("train")[0].split
        )


@pytest.mark.parametrize("line", ["0 a b c d", "9 0.5 0.5 0.1 0.1", "0 0.5 0.5", "0 5 0.5 0.1 0.1"])
def test_hostile_label_files_are_rejected(images_root: Path, tmp_path: Path, line: str) -> None:
    reader = DatasetReader(images_root)
    image = reader.images("train")[0]
    (tmp_path / f"{image.scene_id:06d}_{image.image_id:06d}.txt").write_text(line)
    with pytest.raises(DatasetError, match="line 1"):
        read_labels(tmp_path, reader, "train")


def test_a_class_that_the_dataset_lacks_is_read_back_as_it_was_found(toy_root: Path, tmp_path: Path) -> None:
    reader = DatasetReader(toy_root)
    image = reader.images("test")[0]
    found = [
        FoundObject(image.scene_id, image.image_id, 0.5, name, edges=(1.0, 2.0, 30.0, 20.0))
        for name in ("pallet_face", "pallet")
    ]
    write_results(tmp_path / "found.json", found, reader)
    assert [item.class_name for item in read_results(tmp_path / "found.json", reader, "test")] == [
        "pallet_face",
        "pallet",
    ]
