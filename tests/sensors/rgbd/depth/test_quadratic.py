import numpy as np
import pytest

from tests.sensors.targets import buffers_of, capture_of, plane
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.sensors.rgbd.depth.model import IdealDepth, QuadraticDepth

CAMERA = PinholeCamera.from_focal(500, 400, 500.0)
CAPTURE = capture_of(CAMERA)


def read(depth: np.ndarray, **options: float) -> np.ndarray:
    model = QuadraticDepth(**{"sigma_base": 0.0, "sigma_quadratic": 0.0, "min_range": 0.0, **options})
    return model.read(buffers_of(depth, np.zeros((*depth.shape, 3))), CAPTURE, np.random.default_rng(5))


@pytest.mark.parametrize("z", [0.5, 2.0, 8.0])
def test_the_spread_is_that_of_the_formula(z: float) -> None:
    sigma = 0.001 + 0.002 * z * z
    error = read(np.full((400, 500), z), sigma_base=0.001, sigma_quadratic=0.002) - z
    assert error.std() == pytest.approx(sigma, rel=0.05)
    assert abs(error.mean()) < 5 * sigma * 5 / np.sqrt(error.size)
    double = read(np.full((400, 500), z), sigma_base=0.001, sigma_quadratic=0.002, noise_scale=2)
    np.testing.assert_allclose(double - z, 2 * error, atol=1e-5)


def test_steps_of_inverse_depth_grow_with_the_square_of_depth() -> None:
    depth = np.tile(np.linspace(1.0, 10.0, 5000), (2, 1))
    stepped = read(depth, inverse_depth_step=0.01)
    np.testing.assert_allclose(np.rint(100.0 / stepped), 100.0 / stepped, rtol=1e-5)
    assert (np.abs(1.0 / stepped - 1.0 / depth) <= 0.005 + 1e-6).all()


def test_without_noise_depth_is_the_ground_truth_and_nothing_stays_nothing() -> None:
    depth = np.random.default_rng(0).uniform(0.5, 9, (400, 500)).astype(np.float32)
    depth[:50] = 0.0
    assert np.array_equal(read(depth), depth)
    disturbed = read(depth, sigma_base=0.5, sigma_quadratic=0.1, inverse_depth_step=0.01)
    assert (disturbed[:50] == 0.0).all()
    assert disturbed.min() >= 0.0
    assert disturbed.dtype == np.float32


def test_the_ideal_camera_reads_the_ground_truth_within_its_range() -> None:
    buffers = plane(4.0, 50.0, CAMERA)
    reading = IdealDepth(min_range=3.0, max_range=4.5).read(buffers, CAPTURE, np.random.default_rng(0))
    inside = (buffers.depth >= 3.0) & (buffers.depth <= 4.5)
    assert 0.1 < inside.mean() < 0.9
    assert np.array_equal(reading, np.where(inside, buffers.depth, 0.0))


def test_what_seems_to_lie_out_of_range_is_not_read() -> None:
    depth = read(np.full((400, 500), 4.0), sigma_base=0.1, max_range=4.05, min_range=3.9)
    assert depth[depth > 0].min() >= 3.9
    assert depth.max() <= 4.05
    # Of a Gaussian, 69 % lie below half a sigma and 16 % below minus one.
    assert (depth > 0).mean() == pytest.approx(0.533, abs=0.02)  # windows of 5 x 5 pixels share their noise
