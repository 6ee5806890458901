import numpy as np

from warehouse_sim.render.display import to_display
from warehouse_sim.sensors.rgbd.color.pixels import linear_light

CODES = np.arange(256, dtype=np.uint8)[None, :, None].repeat(3, axis=2)


def test_every_byte_comes_back_from_linear_light() -> None:
    assert np.array_equal(to_display(linear_light(CODES).astype(float)), CODES)
