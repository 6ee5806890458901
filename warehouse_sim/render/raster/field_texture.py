"""The light from the surroundings on the graphics device."""

import moderngl
import numpy as np

from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.irradiance import IrradianceField

_LIFT = 0.3
"""Height over the surface at which light is looked up, in spacings: what is behind must not shine through."""


class FieldTexture:
    """A volume of six blocks above each other, one for each direction; the values are multiplied by their weight."""

    def __init__(self, context: moderngl.Context, field: IrradianceField) -> None:
        nx, ny, nz = self._size = field.weight.shape
        values = np.empty((6, nz, ny, nx, 4), np.float16)
        weight = field.weight.transpose(2, 1, 0)[None, ..., None]
        values[..., :3] = np.minimum(field.irradiance.transpose(3, 2, 1, 0, 4), 6e4) * weight
        values[..., 3:] = weight
        self.texture = context.texture3d((nx, ny, 6 * nz), 4, values.tobytes(), dtype="f2")
        self.texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self.texture.repeat_x = self.texture.repeat_y = self.texture.repeat_z = False
        self._origin, self._spacing = field.origin, field.spacing

    def uniforms(self, T_world_camera: Transform) -> dict[str, object]:
        """Return the uniforms of ``field.glsl`` for a view."""
        cells = T_world_camera[:3] / self._spacing[:, None]
        cells[:, 3] = (T_world_camera[:3, 3] - self._origin) / self._spacing + 0.5
        return {
            "field_size": self._size,
            "field_camera": tuple(cells.T.ravel()),  # columns first
            "world_camera": tuple(T_world_camera[:3, :3].T.ravel()),
            "field_lift": _LIFT * float(self._spacing.mean()),
        }

    def release(self) -> None:
        """Free the device memory."""
        self.texture.release()
