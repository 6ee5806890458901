import numpy as np

from warehouse_sim.sensors.rgbd.color.bayer import demosaic, mosaic


def test_each_pixel_sees_the_colour_of_its_filter() -> None:
    light = np.stack([np.full((4, 6), value, np.float32) for value in (1.0, 2.0, 3.0)], axis=-1)
    assert mosaic(light)[:2, :2].tolist() == [[1.0, 2.0], [2.0, 3.0]]
    assert np.array_equal(mosaic(light)[2:, 2:4], mosaic(light)[:2, :2])


def test_even_colours_come_back_and_details_do_not() -> None:
    flat = np.tile(np.array([0.7, 0.2, 0.4], np.float32), (40, 60, 1))
    np.testing.assert_allclose(demosaic(mosaic(flat)), flat, atol=3e-4)
    fine = np.zeros((40, 60, 3), np.float32)
    fine[:, ::2] = 1.0
    assert np.abs(demosaic(mosaic(fine)) - fine)[5:-5, 5:-5].max() > 0.2
