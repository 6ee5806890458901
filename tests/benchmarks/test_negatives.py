"""What looks like a pallet stands on the floor as it is said to, and shares are those of the threshold."""

import numpy as np
import pytest

from benchmarks.front_ends.negatives import KINDS, summary, things
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import transform_points


def bounds(model, T):
    corners = transform_points(T, np.array(np.meshgrid(*([[-0.5, 0.5]] * 3))).reshape(3, -1).T * model.size)
    return corners.min(axis=0), corners.max(axis=0)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(6))
def test_things_stand_on_the_floor_or_on_each_other_and_not_in_each_other(kind: str, seed: int) -> None:
    placed = things(kind, np.random.default_rng(seed))
    boxes = [bounds(model, T) for model, T in placed]
    for number, (low, high) in enumerate(boxes):
        below = [
            b for a, b in boxes if abs(b[2] - low[2]) < 0.01 and (np.minimum(high, b) > np.maximum(low, a))[:2].all()
        ]
        assert abs(low[2]) < 1e-6 or below
        for i, (a, b) in enumerate(boxes[:number]):
            overlap = np.minimum(high, b) - np.maximum(low, a)
            if (overlap > 0.012).all():
                # Only into an opening of the pallet, which its box does not know.
                assert kind == "blocked pocket"
                assert i == 0
    if kind == "blocked pocket":
        (pallet, T), (block, T_block) = placed[0], placed[-1]
        inside = [OrientedBox(T @ box.T_parent_box, box.size) for box in pallet.collision]
        low, high = bounds(block, T_block)
        for box in inside:
            centre = box.T_parent_box[:3, 3]
            assert not (np.minimum(high, centre + box.size / 2) - np.maximum(low, centre - box.size / 2) > 0.003).all()


def test_a_row_of_cartons_and_a_shelf_hold_no_pallet() -> None:
    for kind in ("three cartons", "shelf"):
        assert all(model.class_name != "pallet" for model, _ in things(kind, np.random.default_rng(0)))


def test_shares_are_counted_from_the_score_on_that_takes_95_of_100_pallets() -> None:
    scores = {kind: [(0.0, 0.0)] * 10 for kind in KINDS}
    scores["pallet"] = [(0.5 + number / 1000, 0.0) for number in range(100)]
    scores["shelf"] = [(0.0, 0.9), *[(0.0, 0.45)] * 9]
    rows = {row["kind"]: row for row in summary(scores, "x")}
    assert rows["pallet"]["value"] >= 0.95
    assert 0.503 <= rows["pallet"]["min_score"] <= 0.506
    assert rows["shelf"]["value"] == pytest.approx(0.1)
    assert rows["three cartons"]["value"] == 0.0
    # Pallets that are all missed accept nothing, and say so.
    none = summary({kind: [(0.0, 0.0)] * 4 for kind in KINDS}, "x")
    assert [row["value"] for row in none] == [0.0] * 5
