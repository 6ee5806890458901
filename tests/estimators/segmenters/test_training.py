"""Training on the toy warehouse, as a person starts it."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from warehouse_sim.cli.main import main
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import InputError, TrainingError, UnknownNameError
from warehouse_sim.estimators.detectors.estimator import TrainedDetector
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.segmenters.segnet import task
from warehouse_sim.estimators.segmenters.segnet.estimator import (
    TrainedSegmenter,
    agreed,
    detection_edges,
    mask_edges,
    without_doubles,
)
from warehouse_sim.estimators.segmenters.segnet.settings import SegmenterConfig
from warehouse_sim.estimators.segmenters.segnet.train import numbered_kinds
from warehouse_sim.estimators.segmenters.segnet.window import Edges
from warehouse_sim.estimators.train import train

CONFIG = SegmenterConfig(
    max_minutes=None,
    max_steps=50,
    batch=8,
    width=8,
    validations=2,
    ema=0.9,
    learning_rate=5e-3,
    threads=1,
    workers=1,
)


@pytest.fixture(scope="module")
def run(toy_root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(task, "_ERRORS", replace(task._ERRORS, depth_holes=0, colour=0.1))
        return train("keypoints-rgbd", toy_root, tmp_path_factory.mktemp("segmenter") / "run", CONFIG)


def boxed(reader: DatasetReader, split: str):
    """Yield images with the ground-truth boxes of what is seen well, and the ground-truth masks."""
    for image in reader.images(split):
        targets = [item for item in image.targets if item.visible_fraction > 0.5 and item.pixels_visible > 100]
        boxes = tuple(Detection(box_xyxy=item.box_visible_xyxy, class_name="pallet") for item in targets)
        masks = [reader.mask_visible(image, item.gt_index) for item in targets]
        yield replace(RgbdImage.from_dataset(reader, image, ()), detections=boxes), masks, image, targets


def test_masks_of_toy_pallets_are_theirs(run: Path, toy_root: Path) -> None:
    segmenter, overlaps = TrainedSegmenter(run), []
    for image, masks, _, _ in boxed(DatasetReader(toy_root), "train"):
        for item in segmenter.segment(image):
            assert item.mask is not None
            assert item.mask_probability is not None
            assert ((item.mask_probability >= 0) & (item.mask_probability <= 1.0001)).all()
            assert (item.mask_probability[item.mask] >= 0.5).all()
            overlaps.append(max((item.mask & gt).sum() / (item.mask | gt).sum() for gt in masks))
    assert np.mean(overlaps) > 0.7
    assert segmenter.segment(replace(image, detections=())) == []


def test_the_network_looks_again_where_its_first_mask_is(run: Path, toy_root: Path) -> None:
    image, *_ = next(boxed(DatasetReader(toy_root), "train"))
    left, top, right, bottom = image.detections[0].box_xyxy
    off = replace(image.detections[0], box_xyxy=(left - 0.15 * (right - left), top, right, bottom))
    segmenter, size_wh = TrainedSegmenter(run), (image.camera.width, image.camera.height)

    def probability(edges: Edges) -> np.ndarray:
        seen = segmenter.look(image, [edges])
        return seen.windows[0].pasted(seen.probability[0], size_wh)

    (found,) = segmenter.segment(replace(image, detections=(off,)))
    again = mask_edges(probability(detection_edges(off)) >= 0.5)
    assert again is not None
    np.testing.assert_array_equal(found.mask_probability, probability(again))
    assert mask_edges(np.zeros((4, 5), bool)) is None


def test_masks_of_the_mirror_image_are_mirrored(run: Path, toy_root: Path) -> None:
    """Whatever it has learned: of a box and its mirror image, the mean is the same for both."""
    image, *_ = next(boxed(DatasetReader(toy_root), "train"))
    assert image.rgb is not None
    mirrored = replace(image, rgb=image.rgb[:, ::-1].copy(), depth=image.depth[:, ::-1].copy())
    edges = [detection_edges(item) for item in image.detections]
    turned = [
        (image.camera.width - right, top, image.camera.width - left, bottom) for left, top, right, bottom in edges
    ]
    segmenter = TrainedSegmenter(run)
    found, expected = segmenter.look(mirrored, turned), segmenter.look(image, edges)
    assert np.ptp(expected.probability) > 0.5
    assert np.abs(expected.probability - expected.probability[..., ::-1]).max() > 0.1
    np.testing.assert_allclose(found.probability[..., ::-1], expected.probability, atol=0.01)


def test_a_segmenter_after_another_looks_at_its_masks_and_gives_the_mean(run: Path, toy_root: Path) -> None:
    image, *_ = next(boxed(DatasetReader(toy_root), "train"))
    segmenter, size_wh = TrainedSegmenter(run), (image.camera.width, image.camera.height)
    before = segmenter.segment(image)[0]
    assert before.mask is not None
    assert before.mask_probability is not None
    # A box that is far off does not matter any more.
    before = replace(before, box_xyxy=(0.0, 0.0, 5.0, 5.0), mask_probability=before.mask_probability * 0.9)
    (after,) = segmenter.segment(replace(image, detections=(before,)))
    seen = segmenter.look(image, [mask_edges(before.mask)])
    said = seen.windows[0].pasted(seen.probability[0], size_wh)
    np.testing.assert_allclose(after.mask_probability, (said + before.mask_probability) / 2, atol=1e-6)
    np.testing.assert_array_equal(after.mask, after.mask_probability >= 0.5)
    alone = before.score / before.mask_probability[before.mask].mean()
    assert after.score == pytest.approx(alone * after.mask_probability[after.mask].mean(), rel=1e-5)


def test_masks_that_nobody_is_sure_of_are_boxes(run: Path, toy_root: Path) -> None:
    image, *_ = next(boxed(DatasetReader(toy_root), "train"))
    box, segmenter = image.detections[0], TrainedSegmenter(run)
    (expected,) = segmenter.segment(replace(image, detections=(box,)))
    nothing = np.zeros(image.depth.shape, dtype=np.float32)
    for mask in (nothing.astype(bool), np.ones(nothing.shape, dtype=np.uint8)):
        (found,) = segmenter.segment(replace(image, detections=(replace(box, mask=mask, mask_probability=nothing),)))
        assert found.score == expected.score
        np.testing.assert_array_equal(found.mask_probability, expected.mask_probability)
    whole = replace(box, mask=expected.mask.astype(np.uint8), mask_probability=expected.mask_probability)
    assert 0.0 < segmenter.segment(replace(image, detections=(whole,)))[0].score <= 1.0


def test_two_who_say_which_kind_it_is_agree_on_the_mean_of_logarithms() -> None:
    found = agreed({"epal1": 0.9, "epal2": 0.1, "keg": 0.5}, {"epal1": 0.4, "epal2": 0.6})
    assert found == pytest.approx({"epal1": 6 / (6 + 6**0.5), "epal2": 6**0.5 / (6 + 6**0.5)})
    assert agreed({"keg": 0.5}, {"epal1": 1.0}) == {"keg": 0.5}


def test_kinds_are_told_by_name_and_strange_ones_rejected(run: Path, toy_root: Path, tmp_path: Path) -> None:
    names = tuple(info.name for info in DatasetReader(toy_root).objects.values())
    config = replace(CONFIG, max_steps=2, validations=1, kinds=names)
    image, *_ = next(boxed(DatasetReader(toy_root), "train"))
    segmenter = TrainedSegmenter(train("segmenter-depth", toy_root, tmp_path / "run", config))
    seen = segmenter.look(image, [detection_edges(item) for item in image.detections])
    assert seen.kinds.shape == (len(image.detections), len(names))
    np.testing.assert_allclose(seen.kinds.sum(axis=1), 1.0, rtol=1e-5)
    for item in segmenter.segment(image):
        assert tuple(item.kind_likelihood) == names
    known = replace(image, detections=tuple(replace(item, kind_likelihood={"keg": 0.5}) for item in image.detections))
    assert TrainedSegmenter(run).segment(replace(known, rgb=image.rgb))[0].kind_likelihood == {"keg": 0.5}
    with pytest.raises(UnknownNameError, match="keg"):
        train("segmenter-depth", toy_root, tmp_path / "other", replace(config, kinds=("keg",)))


def test_two_boxes_of_one_thing_give_one_mask(run: Path, toy_root: Path) -> None:
    image, *_ = next(boxed(DatasetReader(toy_root), "train"))
    left, top, right, bottom = image.detections[0].box_xyxy
    near = replace(image.detections[0], box_xyxy=(left + 2, top, right + 2, bottom), score=0.5)
    alone = TrainedSegmenter(run).segment(image)
    both = TrainedSegmenter(run).segment(replace(image, detections=(near, *image.detections)))
    assert [item.box_xyxy for item in both] == [item.box_xyxy for item in alone]


def test_wrong_uses_are_told_in_one_line(run: Path, toy_root: Path) -> None:
    image, *_ = next(boxed(DatasetReader(toy_root), "train"))
    with pytest.raises(InputError, match="has no rgb"):
        TrainedSegmenter(run).segment(replace(image, rgb=None))
    with pytest.raises(TrainingError, match="kind segmenter, not detector"):
        TrainedDetector(run)


def test_a_command_trains_a_segmenter(toy_root: Path, tmp_path: Path) -> None:
    words = ["train", "segmenter-rgb", "--data", str(toy_root), "--out", str(tmp_path / "run"), "--max-steps", "2"]
    assert main([*words, "--batch", "2", "--width", "4", "--validations", "1"]) == 0
    assert (tmp_path / "run" / "result.json").is_file()


def test_doubles_go_and_neighbours_stay() -> None:
    def of(columns: slice, score: float) -> Detection:
        mask = np.zeros((20, 100), bool)
        mask[5:15, columns] = True
        return Detection(mask, score=score)

    # 40 of 50 columns shared is an IoU of 0.8, 20 of 60 one of 0.33.
    kept, double, neighbour = of(slice(0, 50), 0.9), of(slice(0, 40), 0.8), of(slice(30, 80), 0.95)
    assert without_doubles([double, kept, neighbour]) == [kept, neighbour]
    assert without_doubles([]) == []


def test_a_number_is_one_object_in_all_datasets_of_kinds() -> None:
    def reader(**numbers: int) -> SimpleNamespace:
        objects = {number: SimpleNamespace(name=name) for name, number in numbers.items()}
        return SimpleNamespace(root=Path("set"), objects=objects)

    assert numbered_kinds([reader(euro=1, keg=4), reader(euro=1, half=2)], ("half", "euro")) == {2: 0, 1: 1}
    with pytest.raises(TrainingError, match="object 2 is keg"):
        numbered_kinds([reader(keg=2), reader(euro=1, half=2)], ("half",))
    with pytest.raises(TrainingError, match="object 3 is half"):
        numbered_kinds([reader(half=3), reader(half=2)], ("half",))
