import numpy as np
import pytest

from tests.catalog.covering import volume
from warehouse_sim.catalog.loads.securing import CORNER_POSTS, SLIP_SHEETS, corner_post, slip_sheet


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
