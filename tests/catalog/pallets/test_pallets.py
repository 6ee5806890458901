"""What holds for every pallet of the catalog."""

from collections import Counter

import numpy as np
import pytest

from tests.catalog.pallets.touching import hits, is_closed, prism_of, reaches_into, same_points
from warehouse_sim.catalog.pallets import PALLETS, pallet
from warehouse_sim.catalog.pallets.pockets import Window, pockets_behind, window_between
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.mesh import TriangleMesh, unit_box
from warehouse_sim.geometry.pose import make_transform, rotation_z, transform_points
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.schema import Pocket

# Size (mm), mass (kg), number of deck boards, all boards, wooden blocks; windows (width, height, sill) of the x and
# the y faces (mm). Sources are cited where the pallets are built.
CITED = {
    "epal1": ((1200, 800, 144), 25.0, (5, 11, 9), ((227.5, 100, 0), (382.5, 100, 22))),
    "epal2": ((1200, 1000, 162), 35.0, (9, 17, 9), ((327.5, 118, 22), (382.5, 96, 22))),
    "epal3": ((1200, 1000, 144), 30.0, (7, 13, 9), ((327.5, 100, 0), (382.5, 100, 22))),
    "epal6": ((800, 600, 144), 9.5, (7, 13, 3), ((225, 81, 21), (250, 102, 0))),
    "epal7": ((800, 600, 163), 10.5, (5, 11, 3), ((225, 97, 22), (250, 119, 22))),
    "gma_48x40": ((1219.2, 1016, 120.65), 18.0, (7, 12, 0), ((455.6125, 88.9, 15.875), (228.6, 53.975, 0))),
    "blue_block_1200x1000": ((1200, 1000, 162), 29.0, (7, 15, 9), ((309.5, 120, 21), (360, 99, 21))),
    "plastic_runners": ((1200, 800, 150), 18.0, None, ((227.5, 120, 0), (382.5, 100, 20))),
    "plastic_nestable": ((1200, 800, 140), 6.0, None, ((252.5, 115, 0), (385, 115, 0))),
}
TINE = np.array([1.15, 0.100, 0.040])


def millimetres(values: np.ndarray) -> tuple[float, ...]:
    return tuple(round(float(1000 * value), 6) for value in values)


@pytest.mark.parametrize("name", CITED)
def test_the_outside_and_the_mass_are_as_cited(name: str) -> None:
    model, (size, mass, _, _) = pallet(name), CITED[name]
    assert millimetres(model.size) == size
    assert (model.mass, model.class_name) == (mass, "pallet")


@pytest.mark.parametrize("name", [name for name, cited in CITED.items() if cited[2]])
def test_boards_and_blocks_are_as_many_as_published(name: str) -> None:
    model = pallet(name)
    wooden = [part for part in model.parts if part.material != "galvanised"]
    boards = [part for part in wooden if part.scale[2] < 0.03]
    deck = [part for part in boards if part.T_object_part[2, 3] + part.scale[2] / 2 > model.size[2] / 2 - 1e-9]
    blocks = [part for part in wooden if 0.03 < part.scale[2] < 0.2]
    assert (len(deck), len(boards), len(blocks)) == CITED[name][2]


@pytest.mark.parametrize("name", CITED)
def test_two_pockets_on_each_face_have_the_cited_size(name: str) -> None:
    model = pallet(name)
    assert Counter(pocket.face for pocket in model.pockets) == {"-x": 2, "+x": 2, "-y": 2, "+y": 2}
    for pocket in model.pockets:
        width, height, sill = CITED[name][3]["xy".index(pocket.face[1])]
        depth = model.size["xy".index(pocket.face[1])]
        assert millimetres(pocket.size) == pytest.approx((1000 * depth, width, height))
        bottom = pocket.T_object_pocket[2, 3] - pocket.size[2] / 2 + model.size[2] / 2
        assert 1000 * bottom == pytest.approx(sill, abs=1e-9)


@pytest.mark.parametrize("name", CITED)
def test_pocket_frames_start_at_the_face_and_point_inwards(name: str) -> None:
    model = pallet(name)
    for pocket in model.pockets:
        axis, sign = "xy".index(pocket.face[1]), 1.0 if pocket.face[0] == "+" else -1.0
        T = pocket.T_object_pocket
        assert T[axis, 3] == pytest.approx(sign * model.size[axis] / 2)
        np.testing.assert_allclose(T[:3, 0], -sign * np.eye(3)[axis], atol=1e-12)
        np.testing.assert_allclose(T[:3, 2], [0, 0, 1], atol=1e-12)
        assert np.linalg.det(T[:3, :3]) == pytest.approx(1.0)


@pytest.mark.parametrize("name", CITED)
def test_pockets_are_empty_and_as_wide_and_high_as_can_be(name: str) -> None:
    model = pallet(name)
    for pocket in model.pockets:
        assert not hits(model, *prism_of(pocket, (0.5, -1e-6, -1e-6)))  # free from far outside to far outside
        assert hits(model, *prism_of(pocket, (0.0, 0.002, -0.002)))
        assert hits(model, *prism_of(pocket, (0.0, -0.002, 0.002)))


@pytest.mark.parametrize("name", CITED)
def test_a_pair_of_tines_enters_every_face(name: str) -> None:
    model = pallet(name)
    for pocket in model.pockets:
        T, size = tine_in(pocket)
        assert not hits(model, T, size)
        # Beside the pocket the same tine runs into wood: the test can fail.
        aside = T @ make_transform(translation=np.array([0.0, pocket.size[1] / 2, 0.0]))
        assert hits(model, aside, size)


def tine_in(pocket: Pocket) -> tuple[np.ndarray, np.ndarray]:
    """Return pose and size of a tine that comes from 0.4 m outside and is in as far as it goes."""
    inside = min(TINE[0], pocket.size[0])
    size = np.array([inside + 0.4, TINE[1], TINE[2]])
    return pocket.T_object_pocket @ make_transform(translation=np.array([(inside - 0.4) / 2, 0.0, 0.0])), size


@pytest.mark.parametrize("name", CITED)
def test_physics_leaves_the_pockets_open_and_stands_on_the_same_ground(name: str) -> None:
    model = pallet(name)
    solids = BoxStack.of(model.collision)
    prisms = BoxStack.of([OrientedBox(*prism_of(pocket)) for pocket in model.pockets])
    every = np.argwhere(np.ones((len(model.collision), 8), dtype=bool))
    assert solids.separation(prisms, every).distance.min() > -1e-9
    corners = np.concatenate([box.corners() for box in model.collision])
    np.testing.assert_allclose(corners.max(axis=0), model.size / 2, atol=1e-9)
    assert corners[:, 2].min() == pytest.approx(-model.size[2] / 2)


@pytest.mark.parametrize("name", CITED)
def test_a_half_turn_maps_the_pallet_onto_itself_and_nothing_else_does(name: str) -> None:
    model = pallet(name)
    vertices = model.mesh().vertices
    assert len(model.symmetry) == 2
    for transform in model.symmetry.transforms:
        assert same_points(vertices, transform_points(transform, vertices))
        assert pocket_places(model.pockets) == pocket_places(model.pockets, transform)
    for wrong in (np.diag([1.0, -1.0, -1.0, 1.0]), np.array([[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])):
        assert not same_points(vertices, transform_points(wrong, vertices))


def pocket_places(pockets: tuple[Pocket, ...], T: np.ndarray | None = None) -> set[tuple[float, ...]]:
    moved = [(np.eye(4) if T is None else T) @ pocket.T_object_pocket for pocket in pockets]
    return {
        (*np.round(pose[:3].ravel(), 9) + 0.0, *np.round(pocket.size, 9))
        for pose, pocket in zip(moved, pockets, strict=True)
    }


def test_one_number_stands_for_one_geometry_and_numbers_stay_in_their_range() -> None:
    numbers = {name: pallet(name).obj_id for name in CITED}
    assert numbers["epal1"] == 1
    assert len(set(numbers.values())) == len(CITED)
    assert set(numbers.values()) <= set(range(1, 11))
    for look in PALLETS:
        kind = next(name for name in CITED if look.startswith(name))
        assert pallet(look).obj_id == numbers[kind]
        assert same_points(pallet(look).mesh().vertices, pallet(kind).mesh().vertices)


def test_a_load_finds_a_closed_deck() -> None:
    for name in CITED:
        model = pallet(name)
        plate = model.collision[0]
        assert millimetres(plate.size[:2]) == millimetres(model.size[:2])
        assert plate.T_parent_box[2, 3] + plate.size[2] / 2 == pytest.approx(model.size[2] / 2)
        assert plate.size[2] >= 0.015


SIZE = np.array([1.2, 0.8, 0.144])


def test_the_window_is_what_three_uprights_leave() -> None:
    window = window_between(0.1, 0.145, 0.8, 0.022, 0.122)
    assert window.width == pytest.approx(0.2275)
    assert window.offset == pytest.approx(0.18625)
    assert window.offset - window.width / 2 == pytest.approx(0.145 / 2)
    assert window.offset + window.width / 2 == pytest.approx(0.4 - 0.1)


@pytest.mark.parametrize(("face", "opening"), [("-x", -0.6), ("+x", 0.6), ("-y", -0.4), ("+y", 0.4)])
def test_both_prisms_begin_on_the_face_and_end_on_the_opposite_one(face: str, opening: float) -> None:
    pair = pockets_behind({face: Window(0.2, 0.15, 0.02, 0.12)}, SIZE)
    assert [pocket.face for pocket in pair] == [face, face]
    along = "xy".index(face[1])
    for pocket in pair:
        place = pocket.T_object_pocket[:3, 3]
        assert place[along] == pytest.approx(opening)
        assert abs(place[1 - along]) == pytest.approx(0.15)
        assert place[2] == pytest.approx(0.07 - 0.072)
        np.testing.assert_allclose(pocket.size, [SIZE[along], 0.2, 0.1])
        end = pocket.T_object_pocket @ [pocket.size[0], 0.0, 0.0, 1.0]
        assert end[along] == pytest.approx(-opening)
    assert pair[0].T_object_pocket[1 - along, 3] == pytest.approx(-pair[1].T_object_pocket[1 - along, 3])


@pytest.mark.parametrize(("x", "expected"), [(0.0, True), (0.99, True), (1.0, False), (1.5, False)])
def test_two_unit_boxes_reach_into_each_other_up_to_contact(x: float, expected: bool) -> None:
    # The box is a little larger than the mesh, so that a triangle crosses it even where both share a centre.
    assert reaches_into(unit_box(), make_transform(translation=np.array([x, 0.1, 0.1])), np.ones(3)) is expected


def test_an_edge_between_the_axes_is_seen() -> None:
    corner = 0.5 + np.sqrt(0.5)
    for gap, expected in ((-0.01, True), (0.01, False)):
        T = make_transform(rotation_z(np.pi / 4), np.array([corner + gap, 0.0, 0.0]))
        assert reaches_into(unit_box(), T, np.ones(3)) is expected


def test_a_box_without_a_face_is_not_closed() -> None:
    assert is_closed(unit_box())
    assert not is_closed(TriangleMesh(unit_box().vertices, unit_box().faces[:-1]))
