import numpy as np

from warehouse_sim.render.display import to_display
from warehouse_sim.sensors.rgbd.color.light_curve import display_codes, linear_light

CODES = np.arange(256, dtype=np.uint8)[None, :, None].repeat(3, axis=2)


def test_every_byte_comes_back_from_linear_light() -> None:
    assert np.array_equal(display_codes(linear_light(CODES)), CODES)
    assert np.array_equal(to_display(linear_light(CODES).astype(float)), CODES)


def test_the_table_is_the_renderer_s_curve() -> None:
    linear = np.random.default_rng(0).uniform(0.0, 9.0, (50, 60, 3)) ** 3 / 81.0
    table = display_codes(linear.astype(np.float32)).astype(int)
    exact = to_display(linear).astype(int)
    assert np.abs(table - exact).max() <= 1
    assert (table == exact).mean() > 0.9


def test_what_is_out_of_range_saturates() -> None:
    extremes = np.array([[[-1.0, 0.0, 1e4]]], np.float32)
    assert display_codes(extremes).tolist() == [[[0, 0, 255]]]
