from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ndtr

from tests.sensors.targets import capture_of, corner, plane
from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.motion import Motion
from warehouse_sim.sensors.rgbd import RgbdConfig, read_rgbd
from warehouse_sim.sensors.rgbd.color import IDEAL_COLOR, ColorConfig, read_color
from warehouse_sim.sensors.rgbd.color.optics import add_glare, spread_points
from warehouse_sim.sensors.rgbd.color.pixels import linear_light
from warehouse_sim.sensors.rgbd.depth import PRESETS
from warehouse_sim.sensors.view import Capture

CAMERA = PinholeCamera.from_focal(320, 240, 160.0)
GREY = plane(2.0, camera=CAMERA, code=118)
PLAIN = replace(IDEAL_COLOR, noise_scale=1.0)


def light_of(config: ColorConfig, ev: float | None = None, seed: int = 0, capture: Capture | None = None) -> np.ndarray:
    capture = replace(capture or capture_of(CAMERA), exposure_ev=ev)
    return linear_light(read_color(GREY, capture, config, np.random.default_rng(seed)))


def test_a_darker_scene_at_the_same_brightness_is_noisier() -> None:
    """At N = 2 and 10 ms at most, EV 8.64 needs ISO 100; each stop below doubles the gain and so the variance."""
    clean, noisy = linear_light(GREY.rgb), {ev: light_of(PLAIN, ev) for ev in (12.0, 8.64, 6.64, 3.64)}
    variance = {ev: light.var() for ev, light in noisy.items()}
    quantised = 1 / 12 * (linear_light(GREY.rgb + np.uint8(1)) - clean).mean() ** 2
    x = clean.mean()
    for ev, gain in ((12.0, 1.0), (8.64, 1.0), (6.64, 4.0), (3.64, 32.0)):
        expected = gain * 1e-4 * x + gain**2 * 2e-8 + quantised
        assert variance[ev] == pytest.approx(expected, rel=0.08)
        assert noisy[ev].mean() == pytest.approx(x, rel=0.01)


def test_time_comes_before_gain() -> None:
    assert ColorConfig().shutter_and_gain(10.0) == pytest.approx((4 / 1024, 1.0))
    assert ColorConfig().shutter_and_gain(5.0) == pytest.approx((0.010, 12.5))
    assert ColorConfig().shutter_and_gain(None) == (0.010, 1.0)


def test_corners_are_darker_by_their_share_of_cos_4() -> None:
    full = light_of(replace(IDEAL_COLOR, vignetting=1.0))
    half = light_of(replace(IDEAL_COLOR, vignetting=0.5))
    x, y = 159.5 / 160.0, 119.5 / 160.0
    cosine4 = (1 + x * x + y * y) ** -2.0
    assert full[0, 0, 1] / full[119, 159, 1] == pytest.approx(cosine4, rel=0.03)
    assert half[0, 0, 1] / half[119, 159, 1] == pytest.approx(1 - (1 - cosine4) / 2, rel=0.03)


def test_exposure_and_white_balance_vary_from_image_to_image_by_their_sigma() -> None:
    config = replace(IDEAL_COLOR, exposure_error=0.2, white_balance_error=0.05)
    small = PinholeCamera.from_focal(8, 6, 10.0)
    means = []
    for seed in range(400):
        rgb = read_color(plane(2.0, camera=small, code=118), capture_of(small), config, np.random.default_rng(seed))
        means.append(linear_light(rgb).mean(axis=(0, 1)))
    red, green, blue = np.log2(np.array(means)).T
    assert green.std() == pytest.approx(0.2, rel=0.12)
    for tint in (red - green, blue - green):
        assert tint.std() == pytest.approx(0.05 / np.log(2), rel=0.15)


def test_motion_blur_is_as_long_as_the_shutter_is_open() -> None:
    buffers = replace(GREY, rgb=np.random.default_rng(0).integers(60, 200, GREY.rgb.shape).astype(np.uint8))
    moving = replace(capture_of(CAMERA), motion=Motion(np.array([4.0, 0.0, 0.0])))
    config = replace(IDEAL_COLOR, motion_blur=True)

    def detail(ev: float, setting: ColorConfig = config) -> float:
        rgb = read_color(buffers, replace(moving, exposure_ev=ev), setting, np.random.default_rng(0))
        return float(np.abs(np.diff(rgb.astype(float), axis=1)).mean())

    clean = np.abs(np.diff(buffers.rgb.astype(float), axis=1)).mean()
    assert detail(12.0) == pytest.approx(clean, rel=1e-6)  # 1 ms is 0.3 px
    assert detail(6.0) < 0.6 * clean  # 10 ms are 3.2 px
    assert detail(6.0, replace(config, max_shutter_ms=1.0)) == pytest.approx(clean, rel=1e-6)


def test_the_ideal_camera_and_yaml() -> None:
    assert read_color(GREY, capture_of(CAMERA), IDEAL_COLOR, np.random.default_rng(0)) is GREY.rgb
    assert ColorConfig.from_plain("ideal", "here") == IDEAL_COLOR
    config = ColorConfig(jpeg_quality=80, bayer=False)
    assert from_mapping(ColorConfig, to_mapping(config), "here") == config
    with pytest.raises(ConfigError, match="here: 'iedal' is no colour camera; known: ideal, phone, plain, raw"):
        ColorConfig.from_plain("iedal", "here")


def test_a_stored_image_keeps_the_brightness_and_the_place_of_things() -> None:
    """Each step by default: the mean is that of the light through the camera's curve, and edges stay where they are."""
    edges = GREY.rgb.copy()
    edges[:, 160:] = 60
    still = replace(ColorConfig(), exposure_error=0.0, white_balance_error=0.0, vignetting=0.0, glare=0.0, flicker=0.0)
    images = [
        read_color(replace(GREY, rgb=edges), capture_of(CAMERA), still, np.random.default_rng(seed)).astype(float)
        for seed in range(8)
    ]
    mean = np.mean(images, axis=0)[..., 1].mean(axis=0)
    bright, dark = mean[20:150].mean(), mean[170:300].mean()
    crossing = np.interp(-0.5 * (bright + dark), -mean[150:170], np.arange(150, 170))
    assert crossing == pytest.approx(159.5, abs=0.25)


@pytest.mark.parametrize(
    ("setting", "value"),
    [("noise_scale", float("nan")), ("max_shutter_ms", -2.0),
     ("vignetting", 1.5), ("jpeg_quality", 0),
     ("bits", 7), ("saturation", 0.0), ("black_level", 0.9), ("red_gain", 0.5), ("glare", 1.5),
     ("rolling_shutter_ms", -1.0), ("blur_px", float("inf")), ("denoise", -1.0), ("sharpen", 9.0)],
)  # fmt: skip
def test_impossible_settings_are_rejected_by_name(setting: str, value: float) -> None:
    with pytest.raises(ConfigError, match=setting):
        ColorConfig(**{setting: value})  # type: ignore[arg-type]


def test_an_edge_becomes_the_integral_of_the_point_spread() -> None:
    edge = np.zeros((40, 60, 3), np.float32)
    edge[:, 30:] = 1.0
    profile = spread_points(edge, 1.2)[20, :, 0]
    # A pixel's taps are samples of the Gaussian, so its step lies between two pixels: at 29.5.
    np.testing.assert_allclose(profile, ndtr((np.arange(60) - 29.5) / 1.2), atol=0.012)
    assert spread_points(edge, 0.0) is edge


def test_a_door_in_the_sun_veils_what_is_far_from_it_by_its_share_of_the_mean() -> None:
    """7 times saturation on a tenth of the image: 2/5 of 4 % of 0.7 fall on the far corner, more next to the door."""
    light = np.zeros((320, 640, 3), np.float32)
    light[:, :64] = 7.0
    veiled = add_glare(light, 0.04)
    assert veiled[160, 639, 0] == pytest.approx(0.4 * 0.04 * 0.7, rel=0.02)
    assert veiled[160, 70, 0] > 3 * veiled[160, 639, 0]
    assert veiled.mean() == pytest.approx(light.mean(), rel=0.01)  # scattered, not made


def test_a_lamp_has_a_narrow_halo_in_the_wide_one() -> None:
    light = np.full((480, 840, 3), 0.02, np.float32)
    light[232:248, 400:440] = 7.0
    row = add_glare(light, 0.02)[240, 444:560:4, 0]
    assert np.all(np.diff(row) < 1e-5)
    # Some pixels beside the lamp stand out by more than a fifth, a sigma of the wide halo away by little.
    assert row[0] > 1.2 * row[9]
    assert row[9] < 1.5 * 0.02
    assert add_glare(light, 0.0) is light


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
