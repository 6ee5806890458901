"""Materials and their detail textures on the graphics device."""

from pathlib import Path

import cv2
import moderngl
import numpy as np

from warehouse_sim.errors import RenderError
from warehouse_sim.resources import data_folder
from warehouse_sim.schema import Material

TEXTURE_EDGE_PX = 512
"""Edge of every texture on the device; files of another size are resampled to it."""
_LIMIT = 256  # the geometry buffer stores a material in eight bits


class MaterialTable:
    """One row a material in a float texture, and the detail textures they name in an array texture."""

    def __init__(self, context: moderngl.Context, materials: dict[str, Material]) -> None:
        if len(materials) > _LIMIT:
            raise RenderError(f"a scene holds {len(materials)} materials; the raster backend draws at most {_LIMIT}")
        self.row = {name: number for number, name in enumerate(materials)}
        names = sorted({item.texture for item in materials.values() if item.texture is not None})
        values = np.zeros((max(len(materials), 1), 2, 4), np.float32)
        for row, item in enumerate(materials.values()):
            layer = names.index(item.texture) if item.texture is not None else -1
            values[row, 0] = [*item.base_color, item.roughness]
            values[row, 1] = [item.metallic, item.emission, layer, 1.0 / item.texture_size]
        self.values = context.texture((2, len(values)), 4, values.tobytes(), dtype="f4")
        self.values.filter = (moderngl.NEAREST, moderngl.NEAREST)
        layers = np.stack([load_texture(name) for name in names]) if names else np.full((1, 1, 1), 128, np.uint8)
        size = layers.shape[2], layers.shape[1], layers.shape[0]
        self.textures = context.texture_array(size, 1, layers.tobytes(), alignment=1)
        self.textures.build_mipmaps()
        self.textures.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)

    def release(self) -> None:
        """Free the device memory."""
        self.values.release()
        self.textures.release()


def load_texture(name: str) -> np.ndarray:
    """Read ``assets/textures/NAME.png`` as (512, 512) uint8 factors, 128 = leave the albedo as it is.

    Raises:
        RenderError: The file is missing or is no image.
    """
    path = texture_path(name)
    image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) if path.is_file() else None
    if image is None:
        problem = "is not a readable image" if path.is_file() else "does not exist"
        known = ", ".join(sorted(item.stem for item in path.parent.glob("*.png"))) or "(none)"
        raise RenderError(f"texture {name!r}: {path} {problem}; textures there: {known}")
    if image.shape != (TEXTURE_EDGE_PX, TEXTURE_EDGE_PX):
        image = cv2.resize(image, (TEXTURE_EDGE_PX, TEXTURE_EDGE_PX), interpolation=cv2.INTER_AREA)
    return image


def texture_path(name: str) -> Path:
    """Return where the texture called ``name`` is shipped."""
    return data_folder("assets") / "textures" / f"{name}.png"
