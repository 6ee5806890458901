"""Light as textures on the graphics device: distributions of luminaires, and the light from the surroundings."""

from collections.abc import Sequence

import moderngl
import numpy as np
from jaxtyping import Float16

from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.irradiance import FieldLevel, IrradianceField
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


class FieldTexture:
    """A volume of both levels above each other, laid out as ``field.glsl`` says."""

    def __init__(self, context: moderngl.Context, field: IrradianceField) -> None:
        self._levels = field.levels
        sizes = np.array([level.weight.shape for level in field.levels])
        width, height = int(sizes[:, 0].max()), int(sizes[:, 1].max())
        volumes = [_volume(level, width, height) for level in field.levels]
        self._first = np.cumsum([0, *(len(volume) for volume in volumes)])[:-1]
        values = np.concatenate(volumes)
        self.texture = context.texture3d((width, height, len(values)), 4, values.tobytes(), dtype="f2")
        self.texture.filter = (moderngl.NEAREST, moderngl.NEAREST)

    def uniforms(self, T_world_camera: Transform) -> dict[str, object]:
        """Return the uniforms of ``field.glsl`` for a view."""
        cells = []
        for level in self._levels:
            rows = T_world_camera[:3] / level.spacing[:, None]
            rows[:, 3] = (T_world_camera[:3, 3] - level.origin) / level.spacing
            cells.append(tuple(rows.T.ravel()))  # columns first
        return {
            "field_camera": cells,
            "field_size": [tuple(map(float, level.weight.shape)) for level in self._levels],
            "field_spacing": [tuple(level.spacing) for level in self._levels],
            "field_first": [float(first) for first in self._first],
            "field_fades": [tuple(side) for side in self._levels[0].cut.astype(float)],
            "world_camera": tuple(T_world_camera[:3, :3].T.ravel()),
        }

    def release(self) -> None:
        """Free the device memory."""
        self.texture.release()


def _volume(level: FieldLevel, width: int, height: int) -> Float16[np.ndarray, "z y x 4"]:
    """Return the texels of one level: six blocks of irradiance, then the reach, in cells, up and down the axes."""
    nx, ny, nz = level.weight.shape
    values = np.zeros((8, nz, height, width, 4), np.float16)
    values[:6, :, :ny, :nx, :3] = np.minimum(level.irradiance.transpose(3, 2, 1, 0, 4), 6e4)
    reach = (level.reach.reshape(nx, ny, nz, 2, 3) / level.spacing).transpose(3, 2, 1, 0, 4)
    values[6:, :, :ny, :nx, :3] = reach
    values[6:, :, :ny, :nx, 3] = level.weight.transpose(2, 1, 0)
    return values.reshape(8 * nz, height, width, 4)
