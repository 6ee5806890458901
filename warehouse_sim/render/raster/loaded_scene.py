"""A scene on the graphics device."""

import moderngl

from warehouse_sim.render.raster.lighting import Lighting
from warehouse_sim.render.raster.lights import ShadedLight, order_lights
from warehouse_sim.render.raster.materials import MaterialTable
from warehouse_sim.render.raster.mesh_batch import MeshBatch
from warehouse_sim.render.raster.parts import build_part_table
from warehouse_sim.render.raster.shadows import ShadowAtlas
from warehouse_sim.render.raster.textures import TextureLibrary
from warehouse_sim.schema import SceneSpec


class LoadedScene:
    """Parts, meshes, materials and lights of one scene, ready to draw from any view.

    Args:
        context: Where to upload to.
        spec: The scene.
        shadows: Is drawn for this scene, and serves it until another scene is drawn there.
        textures: Gains the textures that the scene names.

    Raises:
        RenderError: The scene names something that it does not hold, or a texture that is not shipped.
    """

    def __init__(
        self, context: moderngl.Context, spec: SceneSpec, shadows: ShadowAtlas, textures: TextureLibrary
    ) -> None:
        materials = MaterialTable(context, spec.materials, textures)
        self.table = build_part_table(spec, materials.row)
        self.batches = [
            MeshBatch(context, mesh, rows.stop - rows.start)
            for mesh, rows in zip(self.table.meshes, self.table.rows_of_mesh, strict=True)
        ]
        lights = order_lights(spec.lights, spec.viewpoints)
        tiles = shadows.draw(lights, self.table, self.batches)
        shaded = [ShadedLight(light, tile) for light, tile in zip(lights, tiles, strict=True)]
        self.materials = materials
        self.lighting = Lighting(shaded, shadows.depth, materials, spec.ambient, spec.exposure)

    def release(self) -> None:
        """Free the device memory."""
        self.materials.release()
        for batch in self.batches:
            batch.release()
