"""Sheets, posts and film."""

import numpy as np
import pytest

from tests.catalog.covering import volume
from tests.catalog.pallets.touching import is_closed
from warehouse_sim.catalog.loads.securing import CORNER_POSTS, SLIP_SHEETS, corner_post, slip_sheet, stretch_wrap, wrap
from warehouse_sim.catalog.loads.securing.film_skin import Level
from warehouse_sim.catalog.materials import materials


def test_sheets_have_the_sizes_of_pallets_and_the_thickness_of_board() -> None:
    assert {tuple(slip_sheet(name).size[:2]) for name in SLIP_SHEETS} == {
        (1.2, 0.8),
        (1.2, 1.0),
        (1.219, 1.016),
        (0.8, 0.6),
    }
    assert all(0.0006 <= slip_sheet(name).size[2] <= 0.0015 for name in SLIP_SHEETS)
    assert slip_sheet("slip_sheet_1200x800").mass == pytest.approx(750 * 1.2 * 0.8 * 0.0015)


def test_a_post_is_an_angle_whose_corner_is_at_minus_x_minus_y() -> None:
    for name in CORNER_POSTS:
        model = corner_post(name)
        mesh = model.mesh()
        assert volume(mesh) == pytest.approx(0.004 * 0.096 * model.size[2]), name
        assert not np.any((mesh.vertices[:, 0] > -0.02) & (mesh.vertices[:, 1] > -0.02)), name
        assert model.collision == (), name
        assert name == f"corner_post_{round(1000 * model.size[2])}"


SQUARE = np.array([[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]])


def test_film_goes_closely_around_every_level_and_over_the_top() -> None:
    model, centre = stretch_wrap([Level(SQUARE, 0.1, 1.0), Level(SQUARE * 0.5, 1.0, 1.3)])
    vertices = model.mesh().vertices + centre
    np.testing.assert_allclose(np.abs(vertices[:, :2]).max(axis=0), [0.6, 0.4], atol=0.002)
    assert np.all(np.abs(vertices[vertices[:, 2] > 1.001][:, :2]) <= [0.302, 0.202])
    np.testing.assert_allclose([vertices[:, 2].min(), vertices[:, 2].max()], [0.1, 1.3005])
    top = vertices[vertices[:, 2] > 1.2999]
    assert np.abs(top[:, 1]).min() == pytest.approx(0.2 - 0.07, abs=0.002)
    np.testing.assert_allclose(model.size, np.ptp(vertices, axis=0))


def test_film_is_closed_thin_and_translucent() -> None:
    model, _ = stretch_wrap([Level(SQUARE, 0.0, 1.1)])
    (part,) = model.parts
    assert is_closed(part.mesh)
    assert 0.0 < volume(part.mesh) < 0.003 * 4.0 * 1.1  # not filled
    assert 0.0 < materials()[part.material].opacity < 1.0
    assert model.collision == ()
    assert (model.class_name, model.obj_id) == ("wrap", 60)


def test_equal_film_has_an_equal_name_and_other_film_another() -> None:
    one, _ = stretch_wrap([Level(SQUARE, 0.0, 1.1)])
    two, _ = stretch_wrap([Level(SQUARE, 0.0, 1.1)])
    other, _ = stretch_wrap([Level(SQUARE, 0.0, 1.2)])
    assert one.name == two.name
    assert one.name != other.name


def test_the_shell_of_the_catalog_goes_around_a_block_of_its_name() -> None:
    np.testing.assert_allclose(wrap("wrap_1200x800x1000").size, [1.2, 0.8, 1.0], atol=0.003)
