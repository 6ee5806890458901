from dataclasses import replace

import cv2
import numpy as np
import pytest

from warehouse_sim.color import linear_from_srgb
from warehouse_sim.render.display import inverse_tone_map, to_display, tone_map
from warehouse_sim.sensors.rgbd.color import ColorConfig
from warehouse_sim.sensors.rgbd.color.camera import develop
from warehouse_sim.sensors.rgbd.color.pixels import (
    demosaic,
    linear_light,
    mosaic,
    noise_in_codes,
    read_pixels,
)

BARE = ColorConfig(noise_scale=0.0, bayer=False, bits=16, black_level=0.0, red_gain=1.0, blue_gain=1.0)
"""Pixels without noise or filter."""


def read(value: object, config: ColorConfig, gain: float = 1.0) -> np.ndarray:
    light = np.broadcast_to(np.asarray(value, np.float32), (200, 300, 3)).copy()
    return read_pixels(light, [], config, gain, np.random.default_rng(0))


def light_behind(codes: np.ndarray, saturation: float = 1.0) -> np.ndarray:
    """Linear light by the inverse of the sRGB curve and of the tone curve that ends at saturation."""
    return inverse_tone_map(linear_from_srgb(codes / 255.0) * tone_map(np.array(saturation)))


def test_a_full_pixel_is_white_and_not_the_colour_of_its_gains() -> None:
    assert (read(3.0, replace(BARE, red_gain=2.0, blue_gain=1.7)) == 255).all()


@pytest.mark.parametrize("bits", [8, 10, 12])
def test_a_ramp_has_as_many_steps_as_the_converter(bits: int) -> None:
    config = replace(BARE, bits=bits, black_level=0.25)
    ramp = np.linspace(0.0, 0.02, 60_000, dtype=np.float32).reshape(200, 300, 1).repeat(3, axis=2)
    codes = read_pixels(ramp, [], config, 1.0, np.random.default_rng(0))
    steps = int(0.02 * 0.75 * (2**bits - 1)) + 1
    found = len(np.unique(codes))
    assert found <= steps + 1
    if bits < 12:
        assert found >= steps - 1


def test_noise_is_that_of_emva_1288_and_more_of_it_where_a_gain_follows() -> None:
    """Red is half as bright on its pixels and amplified twice: shot noise has twice the variance, read noise four."""
    config = replace(BARE, noise_scale=1.0, red_gain=2.0, blue_gain=1.0, bits=12, black_level=0.0625)
    x, gain = 0.3, 4.0
    found = light_behind(read(x, config, gain).astype(float)).var(axis=(0, 1))
    quantised = np.diff(light_behind(np.array([170.0, 171.0])))[0] ** 2 / 12
    green = gain * 1e-4 * x + gain**2 * 2e-8
    red = 4.0 * (gain * 1e-4 * x / 2.0 + gain**2 * 2e-8)
    assert found[1] == pytest.approx(green + quantised, rel=0.08)
    assert found[0] == pytest.approx(red + quantised, rel=0.08)
    assert found[0] > 1.8 * found[1]


def test_black_keeps_its_mean_because_the_converter_starts_below_it() -> None:
    noisy = replace(BARE, noise_scale=30.0, bits=10)
    pedestal = read(0.0, replace(noisy, black_level=0.0625))
    assert pedestal.min() == 0
    # Half of the noise is below black and shown as black, so just half of the pixels are not black.
    assert (light_behind(pedestal.astype(float)) > 0).mean() == pytest.approx(0.5, abs=0.1)


def test_the_noise_of_a_mid_grey_is_told_in_codes() -> None:
    config = replace(BARE, noise_scale=2.0, bits=12)
    for gain in (4.0, 16.0):
        assert noise_in_codes(config, gain) == pytest.approx(read(0.18, config, gain).std(), rel=0.1)


def test_factors_reach_the_pixels_of_their_channels_behind_the_filter() -> None:
    tint = np.array([0.5, 1.0, 0.25], np.float32)
    rows = np.linspace(0.5, 1.0, 200, dtype=np.float32)[:, None, None]
    light = np.full((200, 300, 3), 0.5, np.float32)
    for factors in ([tint], [rows], [tint * rows]):
        product = light.copy()
        for factor in factors:
            product *= factor
        expected = read_pixels(product, [], replace(BARE, bayer=True), 1.0, np.random.default_rng(0))
        got = read_pixels(light, factors, replace(BARE, bayer=True), 1.0, np.random.default_rng(0))
        assert np.array_equal(got, expected)


def test_each_pixel_sees_the_colour_of_its_filter() -> None:
    light = np.stack([np.full((4, 6), value, np.float32) for value in (1.0, 2.0, 3.0)], axis=-1)
    assert mosaic(light)[:2, :2].tolist() == [[1.0, 2.0], [2.0, 3.0]]
    assert np.array_equal(mosaic(light)[2:, 2:4], mosaic(light)[:2, :2])


def test_even_colours_come_back_and_details_do_not() -> None:
    flat = np.tile(np.array([170, 20, 90], np.float32), (40, 60, 1))
    assert np.array_equal(demosaic(mosaic(flat).astype(np.uint8)), flat.astype(np.uint8))
    fine = np.zeros((40, 60, 3), np.float32)
    fine[:, ::2] = 200.0
    error = np.abs(demosaic(mosaic(fine).astype(np.uint8)).astype(float) - fine)
    assert error[5:-5, 5:-5].max() > 40


@pytest.mark.parametrize("start", [20, 21])
@pytest.mark.parametrize("turned", [False, True])
def test_a_grey_line_of_one_pixel_stays_whole_and_grey(start: int, turned: bool) -> None:
    grey = np.full((40, 60), 140.0, np.float32)
    grey[start] = 60.0
    grey = grey.T if turned else grey
    noisy = grey + np.random.default_rng(0).normal(0.0, 2.0, grey.shape).astype(np.float32)
    found = demosaic(mosaic(np.stack([noisy] * 3, axis=2)).astype(np.uint8)).astype(float)
    line = (found.transpose(1, 0, 2) if turned else found)[start, 3:-3]
    assert line.max() < 80.0
    assert np.abs(np.ptp(found[3:-3, 3:-3], axis=2)).mean() < 8.0


def slow_green(codes: np.ndarray, v: int, u: int) -> float:
    """Return green as the patent says it, pixel by pixel."""
    if (v + u) % 2:
        return float(codes[v, u])
    found = []
    for down, right in ((0, 1), (1, 0)):
        before, after = codes[v - down, u - right], codes[v + down, u + right]
        bend = 2 * codes[v, u] - codes[v - 2 * down, u - 2 * right] - codes[v + 2 * down, u + 2 * right]
        found.append((abs(before - after) + abs(bend), (before + after) / 2 + bend / 4))
    least = min(change for change, _ in found)
    return float(np.clip(np.mean([green for change, green in found if change == least]), 0, 255))


@pytest.mark.parametrize("size", [(12, 14), (11, 13)])
def test_a_mosaic_is_interpolated_as_pixel_by_pixel(size: tuple[int, int]) -> None:
    codes = np.random.default_rng(1).integers(60, 200, size, dtype=np.uint8)
    found, exact = demosaic(codes), codes.astype(float)
    inner = [(v, u) for v in range(4, size[0] - 4) for u in range(4, size[1] - 4)]
    for v, u in inner:
        near = {(y, x): slow_green(exact, y, x) for y in (v - 1, v, v + 1) for x in (u - 1, u, u + 1)}
        expected = [0.0, near[v, u], 0.0]
        for channel, parity in ((0, 0), (2, 1)):
            sites = [place for place in near if place[0] % 2 == place[1] % 2 == parity]
            closest = min(abs(y - v) + abs(x - u) for y, x in sites)
            steps = [exact[p] - near[p] for p in sites if abs(p[0] - v) + abs(p[1] - u) == closest]
            expected[channel] = float(np.clip(near[v, u] + np.mean(steps), 0, 255))
        np.testing.assert_allclose(found[v, u], expected, atol=2.0)


RNG = np.random.default_rng(3)


def grain(sigma: float, code: float = 110.0) -> np.ndarray:
    return np.clip(code + sigma * RNG.standard_normal((240, 320, 3)), 0, 255).astype(np.uint8)


def test_grain_is_less_and_coarser_and_a_median_filter_does_not_remove_it() -> None:
    noisy = grain(4.0)
    developed = develop(noisy, noise=4.0, denoise=1.2, sharpen=0.5)
    assert developed[..., 1].std() < 0.8 * noisy[..., 1].std()

    def left(image: np.ndarray) -> float:
        return float(cv2.medianBlur(image, 3)[..., 1].std() / image[..., 1].std())

    assert left(developed) > left(noisy) + 0.15
    assert left(developed) > 0.6


def test_edges_are_amplified_by_their_fraction() -> None:
    edge = np.full((60, 80, 3), 80, np.uint8)
    edge[:, 40:] = 160
    base = cv2.GaussianBlur(edge[..., 0].astype(float), (5, 5), 0)
    expected = np.clip(base + 1.5 * (edge[..., 0] - base), 0, 255)
    sharp = develop(edge, noise=0.0, denoise=0.0, sharpen=0.5)
    assert np.abs(sharp[..., 0] - expected).max() <= 2.0
    assert sharp.max() > 165


def test_a_thin_line_has_no_colour_and_a_broad_one_keeps_it() -> None:
    for width, least, most in ((1, 0.0, 4.0), (12, 30.0, 100.0)):
        image = np.full((60, 80, 3), 120, np.uint8)
        image[:, 40 : 40 + width] = (160, 110, 70)
        developed = develop(image, noise=1.0, denoise=0.5, sharpen=0.0)[:, 40 + width // 2].astype(int)
        assert least <= np.abs(developed[:, 0] - developed[:, 2]).mean() <= most


def test_more_noise_is_removed_at_a_higher_gain_up_to_a_bound() -> None:
    config = ColorConfig()
    strengths = [config.denoise_at(gain) for gain in (1.0, 4.0, 16.0, 1e5, 1e6)]
    assert strengths[0] == config.denoise
    assert strengths[2] == 2.0 * config.denoise
    assert strengths == sorted(strengths)
    assert strengths[3] == strengths[4] == 3.2
    assert ColorConfig(denoise=5.0).denoise_at(1e6) == 5.0  # a setting is never taken back
    noisy = grain(9.0)
    weak, strong = (develop(noisy, noise=9.0, denoise=value, sharpen=0.8).std() for value in strengths[:3:2])
    assert strong < 0.9 * weak


def test_broad_blotches_of_noise_are_cored_and_an_edge_stays_sharp() -> None:
    coarse = np.kron(RNG.standard_normal((60, 80)), np.ones((4, 4)))[..., None]
    blotched = np.clip(np.rint(120 + 1.5 * coarse), 0, 255).astype(np.uint8).repeat(3, axis=2)
    assert develop(blotched, noise=6.0, denoise=1.0, sharpen=0.0)[..., 1].std() < 0.8 * blotched[..., 1].std()
    edge = np.full((60, 80, 3), 80, np.uint8)
    edge[:, 40:] = 160
    developed = develop(edge, noise=6.0, denoise=1.0, sharpen=0.0)
    assert np.abs(developed.astype(int) - edge).max() < 6  # which a soft threshold takes


CODES = np.arange(256, dtype=np.uint8)[None, :, None].repeat(3, axis=2)


def test_every_byte_comes_back_from_linear_light() -> None:
    assert np.array_equal(to_display(linear_light(CODES).astype(float)), CODES)
