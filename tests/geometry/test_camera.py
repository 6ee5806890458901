import numpy as np
import pytest

from warehouse_sim.geometry.camera import PinholeCamera


def test_focal_constructor_centres_between_pixel_centres() -> None:
    camera = PinholeCamera.from_focal(1224, 370, 721.5377)
    assert (camera.cx, camera.cy) == (611.5, 184.5)


def test_crop_keeps_points_on_the_same_place() -> None:
    camera = PinholeCamera.from_focal(100, 60, 50.0)
    point = np.array([0.3, -0.1, 2.0])
    u, v = camera.project(point)
    window = camera.crop(left=10, top=5, width=40, height=30)
    np.testing.assert_allclose(window.project(point), [u - 10, v - 5])
    doubled = camera.crop(left=10, top=5, width=80, height=60, scale=2.0)
    np.testing.assert_allclose(doubled.project(point), [(u - 10 + 0.5) * 2 - 0.5, (v - 5 + 0.5) * 2 - 0.5])


@pytest.mark.parametrize("bad", [{"width": 0}, {"fx": 0.0}, {"fy": -1.0}])
def test_impossible_intrinsics_are_rejected(bad) -> None:
    with pytest.raises(ValueError, match="found"):
        PinholeCamera(**{"width": 4, "height": 4, "fx": 1.0, "fy": 1.0, "cx": 0.0, "cy": 0.0, **bad})
