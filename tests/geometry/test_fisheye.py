"""The fisheye lens against OpenCV's, its own inverse and finite differences."""

import cv2
import numpy as np
import pytest

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import WIDEST_DEG, Distortion, Fisheye, lens_of, same_lens

LENSES = [
    Fisheye(),
    Fisheye(-0.02, 0.006, -0.004, 0.0007),
    Fisheye(0.05, -0.01, 0.002, -0.0003),
    Fisheye(-1 / 24, 1 / 1920),  # near 2 sin(t / 2): equal solid angles as equal areas
]


def points(most_deg: float, count: int = 2000) -> np.ndarray:
    """Return points of the plane z = 1 in all directions up to an angle to the axis."""
    rng = np.random.default_rng(0)
    r, way = np.tan(np.deg2rad(most_deg) * rng.random(count)), rng.uniform(-np.pi, np.pi, count)
    return np.stack([r * np.cos(way), r * np.sin(way)], axis=1)


@pytest.mark.parametrize("lens", LENSES)
def test_points_are_shown_where_opencv_shows_them(lens: Fisheye) -> None:
    camera = PinholeCamera(1280, 720, 564.0, 570.0, 640.3, 358.1, lens)
    xy = points(75.0)
    scale = np.random.default_rng(1).uniform(0.5, 30.0, len(xy))[:, None]
    seen = np.column_stack([xy, np.ones(len(xy))]) * scale
    wanted, _ = cv2.fisheye.projectPoints(
        seen[:, None], np.zeros(3), np.zeros(3), camera.K, np.array(lens.coefficients)
    )
    np.testing.assert_allclose(camera.project(seen), wanted[:, 0], atol=1e-9)


@pytest.mark.parametrize("lens", LENSES)
def test_remove_is_the_inverse_also_beyond_what_is_believed(lens: Fisheye) -> None:
    for xy in (points(75.9), points(88.0), np.zeros((1, 2))):
        found = lens.remove(lens.apply(xy))
        np.testing.assert_allclose(found, xy, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("lens", LENSES)
def test_the_jacobian_is_that_of_small_steps(lens: Fisheye) -> None:
    xy = np.concatenate([points(75.0), [[0.0, 0.0], [1e-8, 0.0], [2e-6, -1e-6]]])
    step = 1e-6
    columns = [(lens.apply(xy + step * way) - lens.apply(xy - step * way)) / (2 * step) for way in np.eye(2)]
    np.testing.assert_allclose(lens.jacobian(xy), np.stack(columns, axis=-1), atol=1e-8)


def test_the_image_is_continuous_and_grows_at_the_rim_of_what_is_believed() -> None:
    for lens in LENSES:
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
