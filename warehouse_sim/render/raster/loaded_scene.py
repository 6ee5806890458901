"""A scene on the graphics device."""

from collections.abc import Sequence

import moderngl

from warehouse_sim.render.irradiance import LightGatherer
from warehouse_sim.render.lamps import lamp_geometry
from warehouse_sim.render.raster.field_texture import FieldTexture
from warehouse_sim.render.raster.lighting import Lighting
from warehouse_sim.render.raster.lights import ShadedLight, order_lights
from warehouse_sim.render.raster.mesh_batch import MeshLibrary
from warehouse_sim.render.raster.scene_geometry import SceneGeometry
from warehouse_sim.render.raster.shadows import ShadowAtlas
from warehouse_sim.render.raster.textures import TextureLibrary
from warehouse_sim.schema import Light, SceneSpec


class LoadedScene:
    """The geometry and the lights of one scene, ready to draw from any view.

    Args:
        context: Where to upload to.
        spec: The scene.
        shadows: Is drawn for this scene, and serves it until another scene is drawn there.
        textures: Gains the textures that the scene names.
        gatherer: Supplies the light from the surroundings.
        meshes: Gains the meshes of the scene.
        before: The scene that was loaded before; what stands in both, and shadows that did not move, are taken from it.

    Raises:
        RenderError: The scene names something that it does not hold, or a texture that is not shipped.
    """

    def __init__(
        self,
        context: moderngl.Context,
        spec: SceneSpec,
        shadows: ShadowAtlas,
        textures: TextureLibrary,
        gatherer: LightGatherer,
        meshes: MeshLibrary,
        before: "LoadedScene | None" = None,
    ) -> None:
        kept = before if before is not None and before.geometry.is_of(spec) else None
        self.geometry: SceneGeometry = (
            kept.geometry if kept is not None else SceneGeometry(context, spec, textures, meshes)
        )
        self.geometry.glow_as(spec)
        self._field = FieldTexture(context, gatherer.field_of(spec))
        lights = order_lights(spec.lights, spec.viewpoints)
        if kept is not None and _stand_as_before(lights, [item.light for item in kept.lighting.lights]):
            tiles = [item.tile for item in kept.lighting.lights]
        else:
            tiles = shadows.draw(lights, self.geometry.table, self.geometry.batches)
        shaded = [ShadedLight(light, tile) for light, tile in zip(lights, tiles, strict=True)]
        self.lighting: Lighting = Lighting(
            shaded, shadows, self.geometry.materials, self._field, spec.ambient, spec.exposure
        )

    def release(self, after: "LoadedScene | None" = None) -> None:
        """Free the device memory, but for what ``after`` goes on using."""
        self._field.release()
        if after is None or after.geometry is not self.geometry:
            self.geometry.release()


def _stand_as_before(lights: Sequence[Light], before: Sequence[Light]) -> bool:
    """Return whether lamps cast the same shadows as before, however bright they are."""
    return [lamp_geometry(light) for light in lights] == [lamp_geometry(light) for light in before]
