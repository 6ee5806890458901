from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.rgbd import RgbdConfig, read_rgbd

CLEAN = RgbdConfig(sigma_base=0.0, sigma_quadratic=0.0, shot_noise=0.0, read_noise=0.0, min_range=0.5, max_range=10.0)


@pytest.fixture
def buffers() -> RenderBuffers:
    rng = np.random.default_rng(0)
    depth = rng.uniform(0.1, 20.0, (120, 160)).astype(np.float32)
    depth[:10] = 0.0
    rgb = rng.integers(0, 256, (120, 160, 3)).astype(np.uint8)
    return RenderBuffers(rgb, depth, np.ones(depth.shape, np.int32))


def test_a_clean_camera_reads_the_truth_within_its_range(buffers: RenderBuffers) -> None:
    reading = read_rgbd(buffers, CLEAN, np.random.default_rng(0))
    assert np.array_equal(reading.rgb, buffers.rgb)
    in_range = (buffers.depth >= 0.5) & (buffers.depth <= 10.0)
    assert np.array_equal(reading.depth, np.where(in_range, buffers.depth, 0.0))
    assert reading.depth.dtype == np.float32


def test_the_reading_is_decided_by_the_stream(buffers: RenderBuffers) -> None:
    noisy = RgbdConfig()
    first, again, other = (read_rgbd(buffers, noisy, np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert np.array_equal(first.depth, again.depth)
    assert np.array_equal(first.rgb, again.rgb)
    assert not np.array_equal(first.depth, other.depth)
    assert not np.array_equal(first.rgb, other.rgb)


def test_noise_is_applied_as_configured(buffers: RenderBuffers) -> None:
    flat = replace(buffers, depth=np.full((300, 300), 4.0, np.float32))
    reading = read_rgbd(flat, replace(CLEAN, sigma_base=0.002, sigma_quadratic=0.001), np.random.default_rng(0))
    assert reading.depth.std() == pytest.approx(0.018, rel=0.05)


@pytest.mark.parametrize(
    ("setting", "value"),
    [("sigma_base", -0.1), ("shot_noise", -1.0), ("correlation_px", 4), ("correlation_px", 0), ("max_range", 0.2)],
)
def test_impossible_settings_are_refused_by_name(setting: str, value: float) -> None:
    with pytest.raises(ValueError, match=setting):
        RgbdConfig(**{setting: value})  # type: ignore[arg-type]
