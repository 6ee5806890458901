"""Lowering boxes onto each other, against cases that a pencil solves."""

import numpy as np
import pytest

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform, rotation_x, rotation_z
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.loads.resting import drop_to_rest


def box(x: float, z: float, size: tuple[float, float, float] = (1.0, 1.0, 1.0), turn: float = 0.0) -> OrientedBox:
    return OrientedBox(make_transform(rotation_z(turn), np.array([x, 0.0, z])), np.array(size))


@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_it_sinks_by_the_air_under_it(turn: float) -> None:
    upper, lower = BoxStack.of([box(0.0, 1.502, turn=turn)]), BoxStack.of([box(0.0, 0.5, (2.0, 2.0, 1.0))])
    assert drop_to_rest(upper, lower) == pytest.approx(0.002)


@pytest.mark.parametrize(("x", "rests"), [(0.4, True), (0.48, True), (0.51, False), (0.7, False), (1.5, False)])
def test_it_stays_while_its_weight_is_over_what_carries_it(x: float, rests: bool) -> None:
    found = drop_to_rest(BoxStack.of([box(x, 1.5)]), BoxStack.of([box(0.0, 0.5)]))
    # The grid under a piece is 0.25 m wide: close to the edge a stable piece may go unproved, never the other way.
    assert found is None if not rests else found in (None, pytest.approx(0.0))


def test_a_bridge_rests_on_two_and_not_on_one_of_them() -> None:
    span = BoxStack.of([box(0.0, 1.25, (2.0, 1.0, 0.5))])
    left, right = box(-0.8, 0.5, (0.4, 1.0, 1.0)), box(0.8, 0.5, (0.4, 1.0, 1.0))
    assert drop_to_rest(span, BoxStack.of([left, right])) == pytest.approx(0.0)
    assert drop_to_rest(span, BoxStack.of([left])) is None
    shorter = box(0.8, 0.497, (0.4, 1.0, 0.994))
    assert drop_to_rest(span, BoxStack.of([left, shorter])) is None


def test_what_is_inclined_is_not_proved() -> None:
    tilted = OrientedBox(make_transform(rotation_x(0.001), np.array([0.0, 0.0, 0.5])), np.ones(3))
    assert drop_to_rest(BoxStack.of([box(0.0, 1.5)]), BoxStack.of([tilted])) is None
    assert drop_to_rest(BoxStack.of([tilted]), BoxStack.of([box(0.0, -0.5)])) is None


def test_nothing_falls_far_or_out_of_something() -> None:
    floor = BoxStack.of([box(0.0, -0.5, (4.0, 4.0, 1.0))])
    assert drop_to_rest(BoxStack.of([box(0.0, 0.6)]), floor) is None
    assert drop_to_rest(BoxStack.of([box(0.0, 0.4)]), floor) is None
