import numpy as np
import pytest

from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.render.raster.projection import NEAR, projected_bounds
from warehouse_sim.render.renderer import require_view

CAMERA = PinholeCamera(320, 240, 300.0, 280.0, 150.0, 130.0)


def bounds_of(centre: tuple[float, float, float], half: tuple[float, float, float]) -> tuple[float, ...] | None:
    one = np.ones(1)
    return projected_bounds(
        CAMERA, np.eye(3)[None], np.array([centre]), np.zeros((1, 3)), one[:, None] * np.array([half])
    )


def test_bounds_of_a_box_ahead_are_those_of_its_near_face() -> None:
    left, top, right, bottom = bounds_of((0.1, 0.2, 3.0), (0.4, 0.3, 1.0))
    assert (left, right) == pytest.approx((150 + 300 * -0.3 / 2, 150 + 300 * 0.5 / 2))
    assert (top, bottom) == pytest.approx((130 + 280 * -0.1 / 2, 130 + 280 * 0.5 / 2))


def test_a_box_through_the_near_plane_is_cut_there() -> None:
    left, top, right, bottom = bounds_of((0.0, 0.0, 0.5), (0.01, 0.01, 1.0))
    assert (left, right) == pytest.approx((150 - 300 * 0.01 / NEAR, 150 + 300 * 0.01 / NEAR))
    assert (top, bottom) == pytest.approx((130 - 280 * 0.01 / NEAR, 130 + 280 * 0.01 / NEAR))


def test_a_box_behind_has_no_bounds() -> None:
    assert bounds_of((0.0, 0.0, -2.0), (1.0, 1.0, 1.0)) is None


# Views that cannot be rendered are rejected before a graphics library sees them.


@pytest.mark.parametrize("number", ["fx", "fy", "cx", "cy"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_camera_matrix_is_finite(number: str, value: float) -> None:
    numbers = {"fx": 100.0, "fy": 100.0, "cx": 49.5, "cy": 39.5} | {number: value}
    with pytest.raises(ValueError, match="all of the camera matrix finite"):
        PinholeCamera(100, 80, **numbers)


@pytest.mark.parametrize("focal_px", [1e-9, 1e9])
def test_a_focal_length_that_makes_no_view_is_rejected(focal_px: float) -> None:
    with pytest.raises(RenderError, match="cannot be rendered; check its focal lengths"):
        require_view(PinholeCamera.from_focal(100, 80, focal_px), np.eye(4))


def test_a_pose_is_finite_and_a_lens_has_its_own_renderer() -> None:
    camera = PinholeCamera.from_focal(100, 80, 100.0)
    require_view(camera, np.eye(4))
    with pytest.raises(RenderError, match="pose is not finite"):
        require_view(camera, np.full((4, 4), np.nan))
    with pytest.raises(RenderError, match="render with LensRenderer"):
        require_view(PinholeCamera(100, 80, 100.0, 100.0, 49.5, 39.5, Distortion(k1=-0.1)), np.eye(4))
