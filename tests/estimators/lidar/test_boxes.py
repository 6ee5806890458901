"""Back-projection against single pixels, with boxes that leave the image."""

import numpy as np
import pytest

from warehouse_sim.estimators.lidar.boxes import box_points
from warehouse_sim.estimators.rgbd_image import Detection
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion


@pytest.mark.parametrize("lens", [None, Distortion(k1=-0.2)])
@pytest.mark.parametrize(
    "box", [(3, 4, 11, 9), (2.5, 3.2, 10.4, 9.9), (-5, -3, 7, 100), (50, 50, 60, 60), (8, 8, 4, 4)]
)
def test_every_pixel_of_the_box_with_a_reading(lens: Distortion | None, box: tuple[float, ...]) -> None:
    camera = PinholeCamera(20, 14, 30.0, 33.0, 9.0, 6.5, lens)
    depth = np.random.default_rng(0).uniform(1, 5, (14, 20)).astype(np.float32)
    depth[::3, ::2] = 0.0
    found = box_points(camera, depth, box)
    inside = np.argwhere(Detection(box_xyxy=box).pixels(14, 20) & (depth > 0))
    assert list(zip(found.v.tolist(), found.u.tolist(), strict=True)) == [tuple(pixel) for pixel in inside.tolist()]
    np.testing.assert_allclose(found.points[:, 2], depth[found.v, found.u])
    if len(found.points):
        np.testing.assert_allclose(camera.project(found.points), np.column_stack([found.u, found.v]), atol=1e-6)
