"""Views that cannot be rendered are rejected before a graphics library sees them."""

import numpy as np
import pytest

from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.render.renderer import require_view


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
