import cv2
import numpy as np
import pytest

from warehouse_sim.geometry.camera import PinholeCamera, ViewPyramid
from warehouse_sim.geometry.lens import Distortion

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
