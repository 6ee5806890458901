"""What plastic pallets are moulded of."""

import numpy as np
import pytest

from tests.catalog.covering import volume
from tests.catalog.pallets.touching import is_closed, reaches_into, same_points
from warehouse_sim.catalog.pallets import pallet
from warehouse_sim.catalog.pallets.plastic import grid_deck, lattice_solid, nesting_foot, ribbed_block
from warehouse_sim.geometry.pose import make_transform


def test_a_deck_is_its_plate_less_its_holes() -> None:
    deck = grid_deck(0.46, 0.34, 0.02, (4, 3), 0.02, 0.02)
    assert is_closed(deck)
    hole_x, hole_y = (0.46 - 0.04 - 3 * 0.02) / 4, (0.34 - 0.04 - 2 * 0.02) / 3
    assert volume(deck) == pytest.approx((0.46 * 0.34 - 12 * hole_x * hole_y) * 0.02)


def test_a_deck_is_closed_or_wide_open_where_that_is_requested() -> None:
    plain = grid_deck(0.46, 0.34, 0.02, (4, 3), 0.02, 0.02)
    patched = grid_deck(0.46, 0.34, 0.02, (4, 3), 0.02, 0.02, solid=((0.0, 0.0, 0.05, 0.05),))
    opened = grid_deck(0.46, 0.34, 0.02, (4, 3), 0.02, 0.02, open_=((0.0, 0.0, 0.07, 0.07),))
    assert volume(patched) > volume(plain)
    middle = (make_transform(), np.array([0.069, 0.069, 0.1]))
    assert not reaches_into(opened, *middle)
    assert reaches_into(plain, *middle)
    assert is_closed(opened)


def test_a_block_has_recesses_of_the_requested_depth_between_its_ribs() -> None:
    block = ribbed_block(0.145, 0.1, 0.1, 0.045, 0.009, 0.006)
    assert is_closed(block)
    np.testing.assert_allclose(np.ptp(block.vertices, axis=0), [0.145, 0.1, 0.1])
    assert same_points(block.vertices, block.vertices * [-1, -1, 1])
    core = (0.145 - 0.012) * (0.1 - 0.012) * 0.1
    assert core < volume(block) < 0.145 * 0.1 * 0.1
    levels = {round(float(x), 6) for x in np.abs(block.vertices[:, 0])}
    assert {0.0725, 0.0665} <= levels


def test_a_foot_is_a_thin_cup_that_opens_upwards() -> None:
    foot = nesting_foot((0.14, 0.095), (0.105, 0.065), 0.115, 0.004, 0.012)
    assert is_closed(foot)
    assert 0.0 < volume(foot) < 0.25 * 0.14 * 0.095 * 0.115
    top = foot.vertices[foot.vertices[:, 2] > 0.057]
    np.testing.assert_allclose(np.ptp(top, axis=0)[:2], [0.14, 0.095])
    # A second foot of the same size comes to rest far below the deck: they nest.
    assert not reaches_into(
        foot, make_transform(translation=np.array([0.0, 0.0, 0.04])), np.array([0.095, 0.055, 0.03])
    )


X, Y, Z = np.array([0.0, 1.0, 1.5, 4.0]), np.array([-1.0, 0.0, 2.0, 2.5]), np.array([0.0, 0.5])


def test_a_hole_has_walls_and_the_surface_is_closed() -> None:
    filled = np.ones((3, 3, 1), dtype=bool)
    filled[1, 1, 0] = False
    mesh = lattice_solid(X, Y, Z, filled)
    assert volume(mesh) == pytest.approx((4.0 * 3.5 - 0.5 * 2.0) * 0.5)
    edges = mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).tolist()
    assert len({tuple(edge) for edge in edges}) == len(edges)
    assert all([b, a] in edges for a, b in edges)
    # Euler characteristic of a ring: 0.
    assert len(mesh.vertices) - len(edges) // 2 + len(mesh.faces) == 0


def test_only_used_grid_points_become_vertices() -> None:
    filled = np.zeros((3, 3, 1), dtype=bool)
    filled[2, 0, 0] = True
    mesh = lattice_solid(X, Y, Z, filled)
    assert (len(mesh.vertices), len(mesh.faces)) == (8, 12)
    np.testing.assert_array_equal(mesh.vertices.min(axis=0), [1.5, -1.0, 0.0])
    np.testing.assert_array_equal(mesh.vertices.max(axis=0), [4.0, 0.0, 0.5])


def test_the_runner_pallet_keeps_the_clear_widths_of_its_specification() -> None:
    model = pallet("plastic_runners")
    windows = {pocket.face: pocket for pocket in model.pockets}
    between_outer = {
        face: 2 * abs(p.T_object_pocket[1 - "xy".index(face[1]), 3]) + p.size[1] for face, p in windows.items()
    }
    assert between_outer["-x"] >= 0.595
    assert between_outer["-y"] >= 0.900
    assert windows["-x"].size[2] >= 0.090
    assert 0.100 <= round(windows["-y"].size[2], 9) <= 0.103
    assert 0.144 <= model.size[2] <= 0.151
    assert model.mass <= 18.0


def test_feet_stand_under_the_mouths_of_the_deck() -> None:
    model = pallet("plastic_nestable")
    deck, feet = model.parts[0], model.parts[1:]
    assert len(feet) == 9
    assert len({part.mesh for part in feet}) == 1
    for foot in feet:
        x, y, _ = foot.T_object_part[:3, 3]
        mouth = make_transform(translation=np.array([x, y, 0.0]))
        assert not reaches_into(deck.placed(), mouth, np.array([0.13, 0.085, 0.3]))
