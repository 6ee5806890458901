"""The materials of a scene on the graphics device."""

from collections.abc import Collection

import moderngl
import numpy as np

from warehouse_sim.catalog.textures import stretch
from warehouse_sim.errors import RenderError
from warehouse_sim.render.raster.surfaces.textures import PictureLibrary, TextureLibrary
from warehouse_sim.schema import Material
from warehouse_sim.schema.things import RETROREFLECTIVE

_LIMIT = 4096  # the geometry buffer stores a material in twelve bits


class MaterialTable:
    """One row a material in a float texture, and the texture sets and pictures that they name.

    Columns: base colour and roughness; metallic, emission, layer of the texture or -1, tiles a metre across the grain;
    tiles a metre along the grain, opacity, layer of the picture, or -2 where ribs are painted instead, or -1,
    and 1 for retroreflectors.

    Args:
        context: Where to upload to.
        materials: The scene's.
        library: Gains the textures that they name.
        pictures: Holds the pictures that they name from now on.
        ribbed: Names of those that ribbed sheets are made of.

    Raises:
        RenderError: Too many materials, or a texture that is not shipped.
    """

    def __init__(
        self,
        context: moderngl.Context,
        materials: dict[str, Material],
        library: TextureLibrary,
        pictures: PictureLibrary,
        ribbed: Collection[str],
    ) -> None:
        if len(materials) > _LIMIT:
            raise RenderError(f"a scene holds {len(materials)} materials; the raster backend renders at most {_LIMIT}")
        self.row = {name: number for number, name in enumerate(materials)}
        self.library, self.pictures = library, pictures
        layers = library.require(item.texture for item in materials.values() if item.texture is not None)
        shown = pictures.require(item.picture for item in materials.values() if item.picture is not None)
        values = np.zeros((max(len(materials), 1), 3, 4), np.float32)
        for row, item in enumerate(materials.values()):
            layer = layers[item.texture] if item.texture is not None else -1
            along = item.texture_size * (stretch(item.texture) if item.texture is not None else 1)
            values[row, 0] = [*item.base_color, item.roughness]
            values[row, 1] = [item.metallic, item.emission, layer, 1.0 / item.texture_size]
            paint = -2 if item.name in ribbed else -1
            picture = shown[item.picture] if item.picture is not None else paint
            values[row, 2] = [1.0 / along, item.opacity, picture, item.remission >= RETROREFLECTIVE]
        self.retroreflectors = bool((values[:, 2, 3] > 0).any())
        """Whether any of them is one."""
        self.values = context.texture((3, len(values)), 4, values.tobytes(), dtype="f4")
        self.values.filter = (moderngl.NEAREST, moderngl.NEAREST)

    def release(self) -> None:
        """Free the device memory."""
        self.values.release()
