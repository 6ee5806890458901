"""A scene on the graphics device."""

from collections.abc import Sequence

import moderngl
import numpy as np

from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.irradiance import LightGatherer
from warehouse_sim.render.light_grid import lay_grid
from warehouse_sim.render.light_selection import light_geometry, point_ahead, strongest_lights
from warehouse_sim.render.raster.light.contact import ContactMap, ContactMapper
from warehouse_sim.render.raster.light.lighting import (
    MAX_LIGHTS,
    DistributionTexture,
    FieldTexture,
    Lighting,
    ShadedLight,
    distributions_of,
)
from warehouse_sim.render.raster.light.shadows import MAX_SHADOWS, ShadowAtlas, ShadowTile
from warehouse_sim.render.raster.meshes.mesh_batch import MeshBatch, MeshLibrary
from warehouse_sim.render.raster.meshes.parts import ObjectIndex, build_part_table
from warehouse_sim.render.raster.meshes.ribs import ribbed_materials
from warehouse_sim.render.raster.surfaces import MaterialTable, PictureLibrary, TextureLibrary
from warehouse_sim.schema import Light, SceneChange, SceneSpec

_BESIDE = 3.0
"""Distance (m) from a camera within which work lights hang; what comes back to it of farther ones is left out."""


class LoadedScene:
    """One scene, ready to draw from any view; what did not change since the scene before is taken over from it.

    Args:
        context: Where to upload to.
        spec: The scene; see ``require_renderable``.
        shadows: Is rendered for this scene, and serves it until another scene is rendered there.
        contacts: Draws where things stand on the floor.
        textures: Gains the textures that the scene names.
        pictures: Holds the pictures that the scene names from now on.
        meshes: Holds the meshes of the scene from now on.
        before: The scene that was loaded before.

    Raises:
        RenderError: The scene names a texture that is not shipped, or too many materials.
    """

    def __init__(
        self,
        context: moderngl.Context,
        spec: SceneSpec,
        shadows: ShadowAtlas,
        contacts: ContactMapper,
        textures: TextureLibrary,
        pictures: PictureLibrary,
        meshes: MeshLibrary,
        before: "LoadedScene | None" = None,
    ) -> None:
        self._context, self._spec, self._shadows, self._contacts = context, spec, shadows, contacts
        change = SceneChange.between(None if before is None else before._spec, spec)
        if before is None or change.emission or change.objects:
            self.materials = MaterialTable(context, spec.materials, textures, pictures, ribbed_materials(spec))
        else:
            self.materials = before.materials
        shown = before if before is not None and not (change.objects or change.surfaces) else None
        if shown is None:
            self.table = build_part_table(spec, self.materials.row, ribbed_materials(spec))
            self.objects = ObjectIndex.of(self.table)
            self._rendered: tuple[bytes, ...] | None = None
            self._tiles: list[ShadowTile] = []
            self._contact: ContactMap | None = None
        else:
            self.table, self.objects = shown.table, shown.objects
            self._rendered, self._tiles = shown._rendered, shown._tiles
            self._contact = shown._contact
        same_area = None if shown is None or change.area else shown
        self._gatherer: LightGatherer | None = None if same_area is None else same_area._gatherer
        self._field: FieldTexture | None = None if same_area is None or change.lights else same_area._field
        self._distributions: DistributionTexture | None = None
        self.batches: list[MeshBatch] = meshes.require(self.table.meshes) if shown is None else shown.batches

    def holds_what(self, other: SceneSpec) -> bool:
        """Return whether ``other`` holds the very objects and materials of this scene, in another light at most."""
        own = self._spec
        pairs = (own.instances, other.instances), (own.models, other.models), (own.materials, other.materials)
        return all(mine is its for mine, its in pairs)

    def lighting(self, T_world_camera: Transform) -> Lighting:
        """Return what decides how bright surfaces are in a view.

        Shadow maps are rendered, and the light that surfaces send each other is gathered, for the first view; maps
        again only where a scene has more than ``MAX_LIGHTS`` lights.

        Raises:
            MissingPackageError: Embree is not installed.
        """
        field = self._field_of_light()
        self._contact = self._contact or self._contacts.draw(self.table, self.batches)
        place = point_ahead(T_world_camera)
        kept = strongest_lights(self._spec.lights, MAX_LIGHTS, place)
        casting = [light for light in kept if light.kind == "spot" and light.casts_shadow]
        geometries = tuple(map(light_geometry, casting))
        if self._rendered != geometries:
            self._rendered, self._tiles = geometries, self._shadows.draw(casting, self.table, self.batches)
        tile_of = dict(zip(geometries, self._tiles, strict=True))
        with_map = strongest_lights(casting, MAX_SHADOWS, place)
        lights = [ShadedLight(light, tile_of[light_geometry(light)], self._layer(light)) for light in with_map]
        rest = [light for light in kept if not any(light is item for item in with_map)]
        lights += [ShadedLight(light, None, self._layer(light)) for light in rest]
        return Lighting(
            lights,
            self._shadows,
            self.materials,
            field,
            self._contact,
            self._spec.ambient,
            self._spec.exposure,
            self._distributions,
            self.materials.retroreflectors and _beside(kept, T_world_camera),
        )

    def _field_of_light(self) -> FieldTexture:
        """Return the indirect light, and have the luminaires' distributions ready."""
        lights = self._spec.lights
        if self._distributions is None and (own := distributions_of(lights)):
            self._distributions = DistributionTexture(self._context, own)
        if self._field is None:
            self._gatherer = self._gatherer or LightGatherer(lay_grid(self._spec))
            self._field = FieldTexture(self._context, self._gatherer.field(lights, self._spec.ambient))
        return self._field

    def _layer(self, light: Light) -> int | None:
        return None if self._distributions is None else self._distributions.layer(light)


def _beside(lights: Sequence[Light], T_world_camera: Transform) -> bool:
    """Return whether any light is so near to the camera that retroreflectors throw it back there."""
    away = [np.asarray(light.position, float) - T_world_camera[:3, 3] for light in lights]
    return any(float(np.linalg.norm(item)) < _BESIDE for item in away)
