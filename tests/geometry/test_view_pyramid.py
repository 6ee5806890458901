import numpy as np

from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.camera import PinholeCamera, ViewPyramid


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


def test_boxes_are_kept_where_a_corner_or_more_is_in_the_image_and_left_out_beside_it() -> None:
    camera = PinholeCamera.from_focal(320, 200, 200.0)
    pyramid = ViewPyramid.of(camera)
    rng = np.random.default_rng(1)
    rotation = np.linalg.qr(rng.normal(size=(500, 3, 3)))[0]
    centre = rng.uniform((-8, -5, -4), (8, 5, 8), (500, 3))
    half_edges = rotation * np.array([2.5, 0.05, 0.05])[:, None]  # long and thin
    kept = pyramid.touches_boxes(centre, half_edges, 0.05)
    steps = np.linspace(-1, 1, 41)
    points = centre[:, None] + steps[:, None] * half_edges[:, :1]
    inside = ((points @ pyramid.normals.T >= 0).all(axis=2) & (points[..., 2] >= 0.05)).any(axis=1)
    assert kept[inside].all()
    assert 0 < inside.sum() <= kept.sum() < 1.3 * inside.sum() + 10
    spheres = pyramid.touches(centre, np.linalg.norm(half_edges, axis=2).max(axis=1), 0.05)
    assert kept.sum() < 0.7 * spheres.sum()


def test_a_box_reaches_a_plane_as_soon_as_one_of_its_corners_does() -> None:
    camera = PinholeCamera(320, 240, 300.0, 280.0, 40.0, 200.0)
    pyramid = ViewPyramid.of(camera)
    rng = np.random.default_rng(2)
    centre = rng.uniform((-6, -6, -3), (6, 6, 8), (2000, 3))
    rotation = np.linalg.qr(rng.normal(size=(2000, 3, 3)))[0]
    half_edges = rotation * rng.uniform(0.2, 2.0, (2000, 3))[..., None]
    corners = centre[:, None] + box_corners(np.full(3, 2.0)) @ half_edges
    reached = (corners @ pyramid.normals.T >= 0.0).any(axis=1).all(axis=1) & (corners[..., 2] >= 0.05).any(axis=1)
    assert np.array_equal(pyramid.touches_boxes(centre, half_edges, 0.05), reached)
    assert 500 < reached.sum() < 1500
