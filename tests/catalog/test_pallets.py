from collections import Counter

import numpy as np
import pytest

from warehouse_sim.catalog import epal1
from warehouse_sim.catalog.parts import solid_box
from warehouse_sim.errors import UnknownNameError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.geometry.separation import BoxStack

PALLET = epal1()
PARTS = BoxStack.of([OrientedBox(part.T_object_part, part.scale) for part in PALLET.parts])


def millimetres(values: np.ndarray) -> tuple[float, ...]:
    return tuple(round(float(1000 * value), 6) for value in values)


def test_eleven_boards_and_nine_blocks_have_the_published_sizes() -> None:
    sizes = Counter(millimetres(part.scale) for part in PALLET.parts)
    assert sizes == {
        (1200, 145, 22): 4,  # three in the deck, one below
        (1200, 100, 22): 4,  # two in the deck, two below
        (145, 800, 22): 3,
        (145, 100, 78): 6,
        (145, 145, 78): 3,
    }


def test_the_outside_is_1200_x_800_x_144_and_centred() -> None:
    vertices = PALLET.mesh().vertices
    assert millimetres(vertices.min(axis=0)) == (-600, -400, -72)
    assert millimetres(vertices.max(axis=0)) == (600, 400, 72)
    assert millimetres(PALLET.size) == (1200, 800, 144)


def test_deck_boards_lie_in_order_with_gaps_of_41_25_mm() -> None:
    deck = sorted((p for p in PALLET.parts if p.T_object_part[2, 3] > 0.06), key=lambda p: p.T_object_part[1, 3])
    assert [round(1000 * p.scale[1]) for p in deck] == [145, 100, 145, 100, 145]
    edges = np.array([(p.T_object_part[1, 3] - p.scale[1] / 2, p.T_object_part[1, 3] + p.scale[1] / 2) for p in deck])
    np.testing.assert_allclose(edges[1:, 0] - edges[:-1, 1], 0.04125, atol=1e-12)


def test_pieces_touch_and_none_is_inside_another() -> None:
    pairs = np.array([(a, b) for a in range(20) for b in range(a)])
    distance = PARTS.separation(PARTS, pairs).distance
    assert distance.min() > -1e-9
    touching = pairs[distance < 1e-9]
    assert set(touching.ravel()) == set(range(20))


def test_each_face_has_two_pockets_of_the_fork_windows_size() -> None:
    assert Counter(pocket.face for pocket in PALLET.pockets) == {"-x": 2, "+x": 2, "-y": 2, "+y": 2}
    for pocket in PALLET.pockets:
        along_x = pocket.face[1] == "x"
        assert millimetres(pocket.size) == ((1200, 227.5, 100) if along_x else (800, 382.5, 100))
        bottom = pocket.T_object_pocket[2, 3] - pocket.size[2] / 2 + 0.072
        assert bottom == pytest.approx(0.0 if along_x else 0.022, abs=1e-12)


@pytest.mark.parametrize("index", range(8))
def test_a_pocket_is_free_and_as_wide_and_high_as_can_be(index: int) -> None:
    pocket = PALLET.pockets[index]

    def depth_inside(grow: np.ndarray) -> float:
        size = pocket.size + grow
        prism = solid_box(tuple(size), (pocket.size[0] / 2, 0.0, 0.0))
        stack = BoxStack.of([OrientedBox(pocket.T_object_pocket @ prism.T_parent_box, prism.size)])
        return float(PARTS.separation(stack, PARTS.pairs(stack)).distance.min(initial=np.inf))

    assert depth_inside(np.array([0.5, 0.0, 0.0])) > -1e-9  # free from far outside to far outside
    assert depth_inside(np.array([0.0, 0.002, 0.0])) == pytest.approx(-0.001, abs=1e-9)
    assert depth_inside(np.array([0.0, 0.0, 0.002])) == pytest.approx(-0.001, abs=1e-9)


def test_pocket_frames_start_at_the_face_and_point_inwards() -> None:
    for pocket in PALLET.pockets:
        axis, sign = "xy".index(pocket.face[1]), 1.0 if pocket.face[0] == "+" else -1.0
        T = pocket.T_object_pocket
        assert T[axis, 3] == pytest.approx(sign * PALLET.size[axis] / 2)
        np.testing.assert_allclose(T[:3, 0], -sign * np.eye(3)[axis], atol=1e-12)
        np.testing.assert_allclose(T[:3, 2], [0, 0, 1], atol=1e-12)
        assert np.linalg.det(T[:3, :3]) == pytest.approx(1.0)


def test_the_declared_symmetry_maps_the_pallet_onto_itself_and_a_quarter_turn_does_not() -> None:
    assert len(PALLET.symmetry) == 2
    half_turn = PALLET.symmetry.transforms[1]
    vertices = PALLET.mesh().vertices
    assert same_points(vertices, transform_points(half_turn, vertices))
    flip = np.diag([1.0, -1.0, -1.0, 1.0])
    assert not same_points(vertices, transform_points(flip, vertices))


def same_points(a: np.ndarray, b: np.ndarray) -> bool:
    rows = [{tuple(row) for row in np.round(points, 9) + 0.0} for points in (a, b)]
    return rows[0] == rows[1]


def test_the_three_looks_are_one_geometry() -> None:
    looks = [epal1(name) for name in ("epal1", "epal1_new", "epal1_grey")]
    assert {look.obj_id for look in looks} == {1}
    assert len({look.parts[0].material for look in looks}) == 3
    for look in looks:
        np.testing.assert_array_equal(look.mesh().vertices, PALLET.mesh().vertices)
    assert PALLET.mass == 25.0


def test_physics_sees_the_same_outside_and_open_pockets() -> None:
    corners = np.concatenate([box.corners() for box in PALLET.collision])
    assert millimetres(corners.max(axis=0)) == (600, 400, 72)
    assert millimetres(corners.min(axis=0)) == (-600, -400, -72)
    solids = BoxStack.of(PALLET.collision)
    prisms = BoxStack.of(
        [
            OrientedBox(
                pocket.T_object_pocket @ solid_box((0, 0, 0), (pocket.size[0] / 2, 0, 0)).T_parent_box, pocket.size
            )
            for pocket in PALLET.pockets
        ]
    )
    every = np.argwhere(np.ones((len(PALLET.collision), 8), dtype=bool))
    assert solids.separation(prisms, every).distance.min() > -1e-9


def test_an_unknown_look_lists_the_known_ones() -> None:
    with pytest.raises(UnknownNameError, match="epal1_grey"):
        epal1("epal2")
