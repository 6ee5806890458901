import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.view_pyramid import ViewPyramid


def test_points_are_inside_exactly_when_they_project_into_a_pixel() -> None:
    camera = PinholeCamera(320, 240, 300.0, 280.0, 40.0, 200.0)
    points = np.random.default_rng(0).uniform((-4, -4, 0.1), (4, 4, 6), size=(5000, 3))
    u, v = camera.project(points).T
    shown = (u >= -0.5) & (u <= 319.5) & (v >= -0.5) & (v <= 239.5)
    assert np.array_equal(ViewPyramid.of(camera).touches(points, np.zeros(5000)), shown)
    assert 500 < shown.sum() < 4500


def test_a_sphere_touches_as_soon_as_it_reaches_a_plane() -> None:
    camera = PinholeCamera.from_focal(101, 101, 50.5)  # 45 degrees to each side
    pyramid = ViewPyramid.of(camera)
    centre = np.array([[3.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    gap = np.sqrt(2.0)
    assert pyramid.touches(centre, np.full(3, gap + 1e-9)).tolist() == [True, True, True]
    assert pyramid.touches(centre, np.full(3, gap - 1e-9)).tolist() == [False, True, True]
    assert pyramid.touches(centre, np.full(3, 0.5), near=1.6).tolist() == [False, False, False]
