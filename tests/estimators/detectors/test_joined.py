"""Detectors that help each other: boxes and scores by hand."""

from collections.abc import Sequence

import numpy as np
import pytest

from warehouse_sim.estimators.api import Detector, FrontEnd
from warehouse_sim.estimators.detections import open_stages
from warehouse_sim.estimators.detectors.boxes import Kept, helped
from warehouse_sim.estimators.detectors.joined import JoinedDetectors
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.geometry.camera import PinholeCamera

IMAGE = RgbdImage(PinholeCamera(64, 48, 50.0, 50.0, 31.5, 23.5), np.ones((48, 64), dtype=np.float32), ())
LEFT, SHIFTED, RIGHT = (2.0, 4.0, 22.0, 24.0), (4.0, 4.0, 24.0, 24.0), (40.0, 4.0, 60.0, 24.0)


class Fixed(Detector):
    """Finds what it was made with, if sure enough."""

    classes = ("pallet",)

    def __init__(self, *found: Detection) -> None:
        self.found, self.least = found, 0.0

    def leave_out_below(self, min_score: float) -> None:
        self.least = min_score

    def detect(self, image: RgbdImage) -> Sequence[Detection]:
        return [item for item in self.found if item.score > self.least]


def pallet(box: tuple[float, float, float, float], score: float, name: str = "pallet") -> Detection:
    return Detection(box_xyxy=box, score=score, class_name=name)


def test_what_both_find_is_their_weighted_mean() -> None:
    both = JoinedDetectors([Fixed(pallet(LEFT, 0.6)), Fixed(pallet(SHIFTED, 0.9))])
    (found,) = both.detect(IMAGE)
    assert found.score == pytest.approx((0.6 + 0.4 * 0.9) / 1.4)
    # 2 px apart, of which the second's score has 0.36 of 0.96 parts.
    assert found.box_xyxy == pytest.approx((2.75, 4.0, 22.75, 24.0))


def test_what_one_finds_alone_is_less_sure() -> None:
    both = JoinedDetectors([Fixed(pallet(LEFT, 0.8)), Fixed(pallet(RIGHT, 0.9))])
    first, second = both.detect(IMAGE)
    assert (first.box_xyxy, second.box_xyxy) == (pytest.approx(LEFT), pytest.approx(RIGHT))
    assert first.score == pytest.approx(0.8 / 1.4)
    assert second.score == pytest.approx(0.4 * 0.9 / 1.4)
    both.leave_out_below(0.5)
    assert [item.box_xyxy for item in both.detect(IMAGE)] == [pytest.approx(LEFT)]


def test_only_classes_of_the_first_are_looked_for() -> None:
    both = JoinedDetectors([Fixed(), Fixed(pallet(LEFT, 0.9, "person"), pallet(RIGHT, 0.9))])
    assert [item.class_name for item in both.detect(IMAGE)] == ["pallet"]
    assert JoinedDetectors([Fixed(), Fixed()]).detect(IMAGE) == []


def test_what_has_no_score_is_left_out() -> None:
    # As files may hold it; a mean that is weighted by it has no weight.
    both = JoinedDetectors([Fixed(pallet(LEFT, 0.9), pallet(RIGHT, 0.0)), Fixed(pallet(RIGHT, 0.0))])
    both.leave_out_below(-1.0)
    assert [item.box_xyxy for item in both.detect(IMAGE)] == [pytest.approx(LEFT)]


def test_a_mask_stays_with_its_detection() -> None:
    mask = np.zeros((48, 64), dtype=bool)
    mask[4:25, 2:23] = True
    both = JoinedDetectors([Fixed(Detection(mask=mask, score=0.9, class_name="pallet")), Fixed(pallet(LEFT, 0.9))])
    (found,) = both.detect(IMAGE)
    assert found.mask is mask
    assert found.box_xyxy == pytest.approx(LEFT)


def slow(first: list[tuple[np.ndarray, float]], other: list[tuple[np.ndarray, float]]) -> list[tuple[float, ...]]:
    """Pair boxes one by one, by areas of integer pixels."""
    rest, found = list(other), []
    for box, score in sorted(first, key=lambda item: -item[1]):
        overlaps = []
        for mate, _ in rest:
            cells = [np.zeros((40, 40), dtype=bool) for _ in range(2)]
            for cell, (a, b, c, d) in zip(cells, (box, mate), strict=True):
                cell[b:d, a:c] = True
            overlaps.append((cells[0] & cells[1]).sum() / (cells[0] | cells[1]).sum())
        if overlaps and max(overlaps) > 0.5:
            mate, sure = rest.pop(int(np.argmax(overlaps)))
            edges = (score * box + 0.3 * sure * mate) / (score + 0.3 * sure)
            found.append((*edges, (score + 0.3 * sure) / 1.3))
        else:
            found.append((*box, score / 1.3))
    found += [(*box, 0.3 * score / 1.3) for box, score in rest]
    return sorted(found, key=lambda item: -item[4])


@pytest.mark.parametrize("seed", range(8))
def test_pairs_are_those_of_a_slow_count(seed: int) -> None:
    rng = np.random.default_rng(seed)

    def boxes(count: int) -> list[tuple[np.ndarray, float]]:
        corner = rng.integers(0, 12, (count, 2))
        edges = np.concatenate([corner, corner + rng.integers(8, 20, (count, 2))], axis=1)
        return list(zip(edges, rng.uniform(0.1, 1.0, count), strict=True))

    def kept(items: list[tuple[np.ndarray, float]]) -> Kept:
        values = np.array([box for box, _ in items], dtype=float), np.array([score for _, score in items])
        return Kept(*values, np.zeros(len(items), dtype=int), np.arange(len(items)))

    first, other = boxes(6), boxes(7)
    found = helped(kept(first), kept(other), 0.3, 0.5)
    expected = slow(first, other)
    np.testing.assert_allclose(np.column_stack([found.boxes, found.scores]), expected, rtol=1e-12)
    assert sorted(found.rows) == sorted(set(found.rows))


def test_detectors_that_follow_each_other_are_one_stage() -> None:
    stages: list[FrontEnd] = open_stages("detector-depth+detector-rgb+segmenter-depth")
    assert [type(stage).__name__ for stage in stages] == ["JoinedDetectors", "TrainedSegmenter"]
    assert stages[0].reads_rgb
    assert stages[0].reads_depth
    assert stages[0].depth_source == "camera"
