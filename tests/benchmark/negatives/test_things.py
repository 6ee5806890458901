"""What looks like a pallet stands on the floor as it is said to."""

import numpy as np
import pytest

from warehouse_sim.benchmark.negatives.things import KINDS, things
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


def test_nothing_stands_in_an_empty_place() -> None:
    assert things("nothing", np.random.default_rng(0)) == []
