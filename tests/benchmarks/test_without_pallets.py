"""``benchmarks.front_ends.without_pallets`` counts by hand what it shall count."""

import numpy as np
import pytest

from benchmarks.front_ends import without_pallets
from warehouse_sim.estimators.image import Detection

LABELS = np.array([[10.0, 10.0, 30.0, 20.0], [50.0, 10.0, 70.0, 20.0]])
"""Edges (px)."""


def found(left: float, score: float) -> Detection:
    # Edges of pixels are half a pixel beyond their centres.
    return Detection(class_name="pallet", box_xyxy=(left - 0.5, 9.5, left + 19.5, 19.5), score=score)


def test_each_label_takes_the_detection_that_is_most_like_it_and_no_other() -> None:
    assert without_pallets.matched_scores(LABELS, [found(11, 0.9), found(10, 0.8), found(49, 0.3)]) == [0.9, 0.3]
    assert without_pallets.matched_scores(LABELS, [found(25, 0.9)]) == [0.0, 0.0]
    assert without_pallets.matched_scores(np.zeros((0, 4)), [found(10, 0.9)]) == []


@pytest.mark.parametrize(("recall", "score"), [(0.5, 0.9), (1.0, 0.3)])
def test_the_score_is_the_one_from_which_on_enough_is_found(
    recall: float, score: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(without_pallets, "labelled", lambda *rest: LABELS)
    seen = [(None, [found(10, 0.9), found(50, 0.3)])]
    assert without_pallets.score_at(recall, "pallet", None, seen) == (score, 2)  # type: ignore[arg-type]
