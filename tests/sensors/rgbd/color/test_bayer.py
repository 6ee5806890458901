import numpy as np

from warehouse_sim.sensors.rgbd.color.pixels import demosaic, mosaic


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
