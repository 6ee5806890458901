"""Measured distributions of lights on the graphics device, one a layer."""

from collections.abc import Sequence

import moderngl
import numpy as np

from warehouse_sim.schema import IntensityDistribution, Light


class DistributionTexture:
    """The different distributions of some lights: angle from the axis along u, half plane, which repeats, along v."""

    def __init__(self, context: moderngl.Context, distributions: Sequence[IntensityDistribution]) -> None:
        self._distributions = list(distributions)
        layers = np.stack([item.fraction for item in self._distributions])
        count, planes, angles = layers.shape
        self.texture = context.texture_array((angles, planes, count), 1, layers.tobytes(), dtype="f4")
        self.texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self.texture.repeat_x, self.texture.repeat_y = False, True

    def layer(self, light: Light) -> int | None:
        """Return the layer of a light's distribution, None where it has none."""
        same = (number for number, item in enumerate(self._distributions) if item is light.distribution)
        return next(same, None)

    def release(self) -> None:
        """Free the device memory."""
        self.texture.release()


def distributions_of(lights: Sequence[Light]) -> list[IntensityDistribution]:
    """Return the different distributions of ``lights``, in the order of the lights."""
    found = {id(light.distribution): light.distribution for light in lights}
    return [item for item in found.values() if item is not None]
