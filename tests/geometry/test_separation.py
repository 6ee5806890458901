"""Which boxes overlap, and by how much."""

import numpy as np
import pytest

from tests.catalog.covering import volume
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform, matrix_from_quat_wxyz, rotation_z, transform_points
from warehouse_sim.geometry.separation import BoxStack, overlapping_pairs
from warehouse_sim.geometry.solids import lathe, prism, superellipsoid, unit_cylinder, unit_tube

PAIR = np.array([[0, 0]])


def box(size: tuple[float, ...], centre: tuple[float, ...], yaw: float = 0.0) -> OrientedBox:
    return OrientedBox(make_transform(rotation_z(yaw), np.array(centre, dtype=float)), np.array(size, dtype=float))


@pytest.mark.parametrize(
    ("other", "distance", "axis"),
    [
        (box((1, 1, 1), (0, 0, 1.25)), 0.25, (0, 0, 1)),
        (box((1, 1, 1), (-0.75, 0, 0)), -0.25, (-1, 0, 0)),
        (box((1, 1, 1), (0, 2, 0), np.pi / 4), 1.5 - np.sqrt(0.5), (0, 1, 0)),
        (box((1, 1, 1), (0, -0.9, 0.2)), -0.1, (0, -1, 0)),
    ],
)
def test_known_gaps_and_depths(other: OrientedBox, distance: float, axis: tuple[float, ...]) -> None:
    result = BoxStack.of([box((1, 1, 1), (0, 0, 0))]).separation(BoxStack.of([other]), PAIR)
    np.testing.assert_allclose(result.distance, [distance], atol=1e-12)
    np.testing.assert_allclose(result.axis, [axis], atol=1e-12)


def random_boxes(rng: np.random.Generator, count: int) -> list[OrientedBox]:
    rotations = matrix_from_quat_wxyz(rng.normal(size=(count, 4)))
    return [OrientedBox(make_transform(R, rng.uniform(-1, 1, 3)), rng.uniform(0.2, 1.2, 3)) for R in rotations]


def test_agrees_with_points_sampled_inside_random_boxes() -> None:
    rng = np.random.default_rng(0)
    boxes_a, boxes_b = random_boxes(rng, 300), random_boxes(rng, 300)
    pairs = np.stack([np.arange(300), np.arange(300)], axis=1)
    distance = BoxStack.of(boxes_a).separation(BoxStack.of(boxes_b), pairs).distance
    # The largest box, shrunk by the declared depth on each side, must be clear; an overlap must have a common point.
    inside = np.zeros(300, dtype=bool)
    for index, (a, b) in enumerate(zip(boxes_a, boxes_b, strict=True)):
        points = transform_points(a.T_parent_box, rng.uniform(-0.5, 0.5, (4000, 3)) * a.size)
        local = (points - b.T_parent_box[:3, 3]) @ b.T_parent_box[:3, :3]
        inside[index] = np.any(np.all(np.abs(local) < b.size / 2, axis=1))
    assert not np.any(inside & (distance > 0))
    assert np.all(inside[distance < -0.1])
    assert 50 < np.sum(distance > 0) < 250


def test_pairs_finds_every_pair_within_the_margin() -> None:
    rng = np.random.default_rng(2)
    stack = BoxStack.of(random_boxes(rng, 40))
    every = np.argwhere(np.ones((40, 40), dtype=bool))
    touching = every[stack.separation(stack, every).distance <= 0.05]
    found = {tuple(pair) for pair in stack.pairs(stack, 0.05)}
    assert {tuple(pair) for pair in touching} <= found
    assert len(found) < len(every)


def test_distance_to_a_point_and_lines_of_sight() -> None:
    stack = BoxStack.of([box((2, 2, 2), (0, 0, 0)), box((1, 1, 1), (5, 0, 0), np.pi / 4)])
    np.testing.assert_allclose(
        stack.distances_to(np.array([2.0, 2.0, 0.5])),
        [np.sqrt(2.0), np.hypot(np.sqrt(0.5) - 0.5, 5 * np.sqrt(0.5) - 0.5)],
    )
    eye = np.array([-3.0, 0.0, 0.0])
    points = np.array([[3.0, 0.0, 0.0], [-2.0, 0.0, 0.0], [3.0, 5.0, 0.0], [-3.0, 4.0, 0.0]])
    np.testing.assert_array_equal(stack.block(eye, points), [True, False, False, False])


def all_pairs(low_a: np.ndarray, high_a: np.ndarray, low_b: np.ndarray, high_b: np.ndarray) -> np.ndarray:
    near = (low_a[:, None] <= high_b[None]).all(axis=2) & (low_b[None] <= high_a[:, None]).all(axis=2)
    return np.argwhere(near)


@pytest.mark.parametrize("seed", range(6))
def test_the_sweep_finds_what_comparing_all_pairs_finds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    low_a, low_b = (np.round(rng.uniform(0, 6, (count, 3)), 1) for count in (70, 90))  # rounded: many ties
    high_a, high_b = (low + np.round(rng.uniform(0, 2.0, low.shape), 1) for low in (low_a, low_b))
    low_a[0], high_a[0] = 0.0, [40.0, 40.0, 0.1]  # a floor among cartons
    expected = all_pairs(low_a, high_a, low_b, high_b)
    assert len(expected) > 100
    np.testing.assert_array_equal(overlapping_pairs(low_a, high_a, low_b, high_b), expected)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("room", [(60.0, 3.0, 8.0), (30.0, 25.0, 9.0), (2.0, 2.0, 2.0)])
def test_strips_of_a_hall_lose_no_pair_and_name_none_twice(seed: int, room: tuple[float, float, float]) -> None:
    rng = np.random.default_rng(seed)
    low_a, low_b = (np.round(rng.uniform(-1.0, 1.0, (count, 3)) * room, 1) for count in (300, 200))
    high_a, high_b = (low + np.round(rng.uniform(0, 1.2, low.shape), 1) for low in (low_a, low_b))
    low_a[:5], high_a[:5] = -np.array(room), np.array(room) * rng.uniform(-1.0, 1.0, (5, 3)).round(1)  # beams, floors
    high_b[:20] = low_b[:20]  # points
    expected = all_pairs(low_a, high_a, low_b, high_b)
    np.testing.assert_array_equal(overlapping_pairs(low_a, high_a, low_b, high_b), expected)


def test_boxes_that_touch_count_and_empty_sets_have_no_pairs() -> None:
    low, high = np.zeros((1, 3)), np.ones((1, 3))
    np.testing.assert_array_equal(overlapping_pairs(low, high, low + np.eye(3)[0], high + np.eye(3)[0]), [[0, 0]])
    assert overlapping_pairs(low, high, low + 1.001 * np.eye(3)[0], high + 1.001 * np.eye(3)[0]).shape == (0, 2)
    assert overlapping_pairs(low[:0], high[:0], low, high).shape == (0, 2)


L_SHAPE = ((0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0))
UNIT = {
    "cylinder": unit_cylinder(),
    "tube": unit_tube(0.9),
    "sack": superellipsoid(dent=0.3),
}
SOLIDS = UNIT | {
    "bottle": lathe(((0.0, 0.0), (0.4, 0.0), (0.4, 1.0), (0.1, 1.2), (0.1, 1.5), (0.0, 1.5))),
    "prism": prism(L_SHAPE, 2.0),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_every_edge_is_walked_once_each_way_and_no_face_is_flat(name: str) -> None:
    mesh = SOLIDS[name]
    edges = np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]])
    directed = {tuple(edge) for edge in edges.tolist()}
    assert len(directed) == len(edges)
    assert all((b, a) in directed for a, b in directed)
    assert mesh.face_areas().min() > 1e-8
    assert volume(mesh) > 0.0


@pytest.mark.parametrize("name", UNIT)
def test_unit_solids_fill_the_unit_cube(name: str) -> None:
    np.testing.assert_allclose(UNIT[name].vertices.min(axis=0), -0.5, atol=1e-12)
    np.testing.assert_allclose(UNIT[name].vertices.max(axis=0), 0.5, atol=1e-12)


def test_volumes_are_those_of_the_formulas() -> None:
    circle = 96 / 8 * np.sin(2 * np.pi / 96)  # area of the regular 96-gon in a circle of diameter 1
    assert volume(unit_cylinder(96)) == pytest.approx(circle)
    assert volume(unit_tube(0.8, 96)) == pytest.approx(circle * (1 - 0.64))
    assert volume(prism(L_SHAPE, 2.0)) == pytest.approx(2 * 4.0)
    assert volume(superellipsoid(2.0, 2.0, 96, 96)) == pytest.approx(np.pi / 6, rel=0.005)
    assert volume(superellipsoid(20.0, 20.0, 96, 96)) > 0.9


def test_quarter_turns_leave_a_round_solid_unchanged_without_rounding() -> None:
    points = {tuple(row) for row in unit_cylinder(32).vertices.tolist()}
    assert {(-y, x, z) for x, y, z in points} == points


def test_impossible_solids_are_rejected() -> None:
    with pytest.raises(ValueError, match="multiple of 4"):
        unit_cylinder(10)
    with pytest.raises(ValueError, match="begin and end on the axis"):
        lathe(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)))
    with pytest.raises(ValueError, match="counter-clockwise"):
        prism(L_SHAPE[::-1])
