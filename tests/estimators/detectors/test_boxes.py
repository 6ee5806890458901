import numpy as np
import pytest

from warehouse_sim.estimators.detectors.boxes import suppress


def slow_suppress(boxes: np.ndarray, scores: np.ndarray, least: float, most: float) -> list[tuple[int, int]]:
    """Take the best box again and again and strike out what overlaps it, box by box in plain Python."""
    left = [(float(scores[i, c]), i, c) for i in range(len(boxes)) for c in range(scores.shape[1])]
    left = sorted((item for item in left if item[0] > least), key=lambda item: -item[0])
    kept = []
    while left:
        _, row, number = left.pop(0)
        kept.append((row, number))
        a = boxes[row]
        remaining = []
        for item in left:
            b = boxes[item[1]]
            w = max(0.0, min(a[2], b[2]) - max(a[0], b[0]))
            h = max(0.0, min(a[3], b[3]) - max(a[1], b[1]))
            union = (a[2] - a[0]) * (a[3] - a[1]) + (b[2] - b[0]) * (b[3] - b[1]) - w * h
            if item[2] != number or w * h / union <= most:
                remaining.append(item)
        left = remaining
    return kept


def crowded(rng: np.random.Generator, count: int, classes: int) -> tuple[np.ndarray, np.ndarray]:
    low = rng.uniform(0, 600, (count, 2)) * [1, 0.3]
    return np.concatenate([low, low + rng.uniform(8, 150, (count, 2)) * [1, 0.3]], axis=1), rng.random((count, classes))


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("classes", [1, 3])
def test_the_same_boxes_stay_as_in_a_slow_count(seed: int, classes: int) -> None:
    boxes, scores = crowded(np.random.default_rng(seed), 120, classes)
    kept = suppress(boxes, scores, 0.3, 0.5)
    assert list(zip(kept.rows.tolist(), kept.classes.tolist(), strict=True)) == slow_suppress(boxes, scores, 0.3, 0.5)
    np.testing.assert_array_equal(kept.boxes, boxes[kept.rows])
    assert (np.diff(kept.scores) <= 0).all()


def test_nothing_remains_of_nothing() -> None:
    assert len(suppress(np.zeros((0, 4)), np.zeros((0, 2))).boxes) == 0
    assert len(suppress(np.zeros((5, 4)), np.zeros((5, 2))).boxes) == 0
