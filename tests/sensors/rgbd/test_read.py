from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.targets import capture_of, corner
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.rgbd import RgbdConfig, read_rgbd
from warehouse_sim.sensors.rgbd.color import IDEAL_COLOR, ColorConfig
from warehouse_sim.sensors.rgbd.depth import PRESETS


@pytest.fixture
def buffers() -> RenderBuffers:
    clean = corner(1.5, concave=True)
    return replace(clean, rgb=np.random.default_rng(0).integers(0, 256, clean.rgb.shape).astype(np.uint8))


def test_settings_of_colour_leave_depth_alone_and_the_other_way_round(buffers: RenderBuffers) -> None:
    def read(config: RgbdConfig) -> tuple[np.ndarray, np.ndarray]:
        reading = read_rgbd(buffers, capture_of(), config, np.random.default_rng(1))
        return reading.rgb, reading.depth

    rgb, depth = read(RgbdConfig())
    for color in (IDEAL_COLOR, ColorConfig(noise_scale=10.0, bayer=True), ColorConfig(jpeg_quality=70)):
        other_rgb, same_depth = read(RgbdConfig(color=color))
        assert np.array_equal(depth, same_depth)
        assert not np.array_equal(rgb, other_rgb)
    for model in PRESETS.values():
        same_rgb, other_depth = read(RgbdConfig(depth=model))
        assert np.array_equal(rgb, same_rgb)
        assert not np.array_equal(depth, other_depth)
