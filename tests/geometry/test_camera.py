"""The camera and the part of space that its image shows."""

import cv2
import numpy as np
import pytest

from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.camera import PinholeCamera, ViewPyramid
from warehouse_sim.geometry.lens import WIDEST_DEG, Distortion, Fisheye, lens_of, same_lens


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


# Both kinds of lens against OpenCV's, their own inverses and finite differences.


BARREL = Distortion(k1=-0.3691481, k2=0.1968681, p1=0.001353473, p2=0.0005677587, k3=-0.06770705)
PINCUSHION = Distortion(k1=0.2, p1=0.002, p2=-0.001)
MUSTACHE = Distortion(k1=-0.3, k2=0.1)
LENSES = pytest.mark.parametrize("lens", [BARREL, PINCUSHION, MUSTACHE])


def camera_with(lens: Distortion) -> PinholeCamera:
    return PinholeCamera(160, 90, 125.0, 123.0, 81.3, 43.8, lens)


def test_rays_of_pixels_are_looked_up_and_equal_those_that_are_computed() -> None:
    camera = camera_with(BARREL)
    u, v = np.array([0, 17, 159, 80]), np.array([0, 89, 89, 44])
    np.testing.assert_allclose(camera.rays_at(u, v), camera.rays_at(u.astype(float), v.astype(float)), atol=1e-11)
    outside = np.array([-3, 160]), np.array([5, 200])
    np.testing.assert_allclose(camera.project(camera.rays_at(*outside)), np.stack(outside, axis=1), atol=1e-6)


@LENSES
def test_the_canvas_around_the_image_is_covered_once_and_no_far_point_folds_back(lens: Distortion) -> None:
    camera = camera_with(lens)
    u, v = np.meshgrid(np.arange(-160.0, 320.0, 7.0), np.arange(-90.0, 180.0, 7.0))
    canvas = np.stack([u.ravel(), v.ravel()], axis=1)
    np.testing.assert_allclose(camera.project(camera.rays_at(*canvas.T)), canvas, atol=1e-5)
    angles = np.linspace(0.0, 2.0 * np.pi, 33)[:, None]
    radii = np.concatenate([np.linspace(0.01, 3.0, 200), [10.0, 1000.0]])
    shown = lens.apply(np.stack([np.cos(angles) * radii, np.sin(angles) * radii], axis=-1))
    assert (np.diff(np.hypot(shown[..., 0], shown[..., 1]), axis=1) > 0).all()


def test_the_plain_formula_folds_where_the_continued_one_does_not() -> None:
    far = np.array([[3.0, 0.0, 1.0]])
    camera = camera_with(Distortion(k1=-0.3))
    folded, _ = cv2.projectPoints(far, np.zeros(3), np.zeros(3), camera.K, np.array([-0.3, 0, 0, 0, 0]))
    assert folded[0, 0, 0] < 0  # beyond the left border, although the point is to the right
    assert camera.project(far)[0, 0] > 159


@LENSES
def test_the_jacobian_is_the_slope_of_the_map(lens: Distortion) -> None:
    xy = np.random.default_rng(2).uniform(-0.5, 0.5, size=(40, 2))
    step = 1e-6
    slopes = [(lens.apply(xy + move) - lens.apply(xy - move)) / (2 * step) for move in step * np.eye(2)]
    np.testing.assert_allclose(lens.jacobian(xy), np.stack(slopes, axis=-1), atol=1e-8)


def test_a_lens_that_folds_inside_the_image_is_rejected_in_one_line() -> None:
    with pytest.raises(ValueError, match=r"k1=-0\.3691481 .* 47\.9 deg off its axis, inside its borders") as caught:
        PinholeCamera(1224, 370, 721.5, 721.5, 611.5, 184.5, BARREL).require_clear_lens()
    assert "\n" not in str(caught.value)
    PinholeCamera(1392, 512, 959.791, 956.9251, 696.0217, 224.1806, BARREL).require_clear_lens()
    with pytest.raises(ValueError, match="k1 must be -100 to 100, found nan"):
        Distortion(k1=float("nan"))


def test_a_window_of_the_image_shows_points_at_the_same_place() -> None:
    camera = camera_with(BARREL)
    point = np.array([0.3, -0.1, 1.0])
    u, v = camera.project(point)
    np.testing.assert_allclose(
        camera.crop(10, 5, 40, 30, 2.0).project(point), [(u - 9.5) * 2 - 0.5, (v - 4.5) * 2 - 0.5]
    )


@LENSES
def test_the_view_pyramid_holds_all_rays(lens: Distortion) -> None:
    camera = camera_with(lens)
    pyramid = ViewPyramid.of(camera)
    assert (camera.rays().reshape(-1, 3) @ pyramid.normals.T > 0).all()
    left, right, top, bottom = camera.tangent_bounds()
    assert pyramid.touches(np.array([[0.99 * left, 0.0, 1.0], [1.05 * right, 0.0, 1.0]]), np.zeros(2)).tolist() == [
        1,
        0,
    ]
    assert top < camera.rays()[..., 1].min() < top + 0.02
    assert bottom > camera.rays()[..., 1].max() > bottom - 0.02


def test_without_its_lens_a_camera_is_the_pinhole() -> None:
    camera = camera_with(BARREL)
    pinhole = camera.pinhole
    assert pinhole.distortion is None
    assert pinhole.pinhole is pinhole
    assert np.array_equal(pinhole.K, camera.K)
    axis = np.array([0.0, 0.0, 2.0])
    np.testing.assert_array_equal(pinhole.project(axis), camera.project(axis))


FISHEYES = [
    Fisheye(),
    Fisheye(-0.02, 0.006, -0.004, 0.0007),
    Fisheye(0.05, -0.01, 0.002, -0.0003),
    Fisheye(-1 / 24, 1 / 1920),  # near 2 sin(t / 2): equal solid angles as equal areas
]


def fisheye_points(most_deg: float, count: int = 2000) -> np.ndarray:
    """Return fisheye_points of the plane z = 1 in all directions up to an angle to the axis."""
    rng = np.random.default_rng(0)
    r, way = np.tan(np.deg2rad(most_deg) * rng.random(count)), rng.uniform(-np.pi, np.pi, count)
    return np.stack([r * np.cos(way), r * np.sin(way)], axis=1)


@pytest.mark.parametrize("lens", FISHEYES)
def test_points_are_shown_where_opencv_shows_them(lens: Fisheye) -> None:
    camera = PinholeCamera(1280, 720, 564.0, 570.0, 640.3, 358.1, lens)
    xy = fisheye_points(75.0)
    scale = np.random.default_rng(1).uniform(0.5, 30.0, len(xy))[:, None]
    seen = np.column_stack([xy, np.ones(len(xy))]) * scale
    wanted, _ = cv2.fisheye.projectPoints(
        seen[:, None], np.zeros(3), np.zeros(3), camera.K, np.array(lens.coefficients)
    )
    np.testing.assert_allclose(camera.project(seen), wanted[:, 0], atol=1e-9)


@pytest.mark.parametrize("lens", FISHEYES)
def test_remove_is_the_inverse_also_beyond_what_is_believed(lens: Fisheye) -> None:
    for xy in (fisheye_points(75.9), fisheye_points(88.0), np.zeros((1, 2))):
        found = lens.remove(lens.apply(xy))
        np.testing.assert_allclose(found, xy, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("lens", FISHEYES)
def test_the_jacobian_is_that_of_small_steps(lens: Fisheye) -> None:
    xy = np.concatenate([fisheye_points(75.0), [[0.0, 0.0], [1e-8, 0.0], [2e-6, -1e-6]]])
    step = 1e-6
    columns = [(lens.apply(xy + step * way) - lens.apply(xy - step * way)) / (2 * step) for way in np.eye(2)]
    np.testing.assert_allclose(lens.jacobian(xy), np.stack(columns, axis=-1), atol=1e-8)


def test_the_image_is_continuous_and_grows_at_the_rim_of_what_is_believed() -> None:
    for lens in FISHEYES:
        r = np.linspace(0.99 * lens.radius, 1.01 * lens.radius, 101)
        shown = lens.apply(np.stack([r, np.zeros_like(r)], axis=1))[:, 0]
        assert (np.diff(shown) > 0).all()
        assert np.diff(shown).max() < 0.01


def test_what_folds_or_reaches_too_far_is_rejected() -> None:
    PinholeCamera(1280, 720, 564.0, 564.0, 639.5, 359.5, Fisheye()).require_clear_lens()
    with pytest.raises(ValueError, match=r"fisheye k1=0.0 k2=0.0 k3=0.0 k4=0.0 squeezes .* 76.0 deg off its axis"):
        PinholeCamera(1280, 720, 540.0, 540.0, 639.5, 359.5, Fisheye()).require_clear_lens()
    # t - 0.4 t^3 grows by less than a quarter from t^2 = 0.625 on, 45.3 deg.
    folding = Fisheye(-0.4)
    assert np.degrees(np.arctan(folding.radius)) == pytest.approx(np.degrees(np.sqrt(0.625)), abs=1e-9)
    with pytest.raises(ValueError, match=r"45\.3 deg"):
        PinholeCamera(1280, 720, 564.0, 564.0, 639.5, 359.5, folding).require_clear_lens()
    with pytest.raises(ValueError, match=r"k1 must be -10 to 10, found 11\.0"):
        Fisheye(11.0)


def test_a_lens_is_told_by_the_number_of_its_coefficients() -> None:
    assert lens_of([0.1, 0.2, 0.3, 0.4]) == Fisheye(0.1, 0.2, 0.3, 0.4)
    assert lens_of([0.1, 0.2, 0.3, 0.4, 0.5]) == Distortion(0.1, 0.2, 0.3, 0.4, 0.5)
    with pytest.raises(ValueError, match="found 3"):
        lens_of([0.1, 0.2, 0.3])
    assert same_lens(None, Distortion())
    assert not same_lens(None, Fisheye())
    assert not same_lens(Fisheye(0.1), Fisheye(0.2))


def test_the_widest_angle_is_an_image_of_130_degrees_across() -> None:
    half = np.hypot(65.0, 65.0 * 720 / 1280)
    assert half < WIDEST_DEG
