import numpy as np
import pytest

from tests.catalog.covering import volume
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.building.shell import (
    OPENING_HEIGHT,
    OPENING_WIDTH,
    WALL_SIZE,
    profile,
    profile_points,
    profiled_solid,
)
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.geometry.separation import BoxStack


def test_a_profiled_solid_has_the_volume_between_its_lines() -> None:
    x = np.array([0.0, 1.0, 3.0])
    mesh = profiled_solid(x, np.zeros(3), np.array([1.0, 2.0, 2.0]), 0.5)
    assert volume(mesh) == pytest.approx((1.5 + 4.0) * 0.5)


def test_ribs_repeat_every_200_mm_and_are_even() -> None:
    x = np.linspace(-0.5, 0.5, 101)
    np.testing.assert_allclose(profile(x + 0.2), profile(x), atol=1e-6)
    np.testing.assert_allclose(profile(-x), profile(x), atol=1e-6)
    assert (profile(np.array([0.0, 0.1])) == [0.0, 1.0]).all()


def test_folds_of_a_piece_are_those_of_the_whole_sheet() -> None:
    piece = profile_points(0.07, 0.75)
    assert (piece[0], piece[-1]) == (0.07, 0.75)
    whole = profile_points(-1.0, 1.0)
    assert all(np.abs(whole - at).min() < 1e-9 for at in piece[1:-1])
    assert np.diff(piece).min() > 0.0


def test_a_dock_module_is_open_where_the_door_goes() -> None:
    module = catalog_object("wall_module_dock")
    floor = -WALL_SIZE[2] / 2
    opening = OrientedBox(
        make_transform(translation=np.array([0.0, 0.0, floor + OPENING_HEIGHT / 2])),
        np.array([OPENING_WIDTH - 1e-6, 1.0, OPENING_HEIGHT - 1e-6]),
    )
    assert BoxStack.of(module.collision).clear_of(opening, 0.0)
    vertices = module.mesh().vertices
    inside = (np.abs(vertices[:, 0]) < OPENING_WIDTH / 2 - 1e-9) & (vertices[:, 2] < floor + OPENING_HEIGHT - 1e-9)
    assert not inside.any()


@pytest.mark.parametrize("name", ["floor_slab_jointed", "floor_slab_epoxy"])
def test_joints_are_sawn_into_the_slab_every_6_m(name: str) -> None:
    panels = catalog_object(name).parts[0].placed().vertices
    edges = np.unique(np.round(panels[:, 0], 6))
    np.testing.assert_allclose(np.diff(edges)[1::2], 0.01, atol=1e-6)
    np.testing.assert_allclose((edges[1:-1:2] + edges[2:-1:2]) / 2, np.arange(-18.0, 19.0, 6.0), atol=1e-6)
    assert panels[:, 2].max() - panels[:, 2].min() == pytest.approx(0.02)
    assert catalog_object(name).parts[1].material == "floor_joint"
