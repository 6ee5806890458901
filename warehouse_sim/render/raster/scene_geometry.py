"""What stands in a scene, on the graphics device: parts, meshes and materials, without its light."""

from collections.abc import Mapping

import moderngl

from warehouse_sim.render.raster.materials import MaterialTable
from warehouse_sim.render.raster.mesh_batch import MeshLibrary
from warehouse_sim.render.raster.object_index import ObjectIndex
from warehouse_sim.render.raster.parts import build_part_table
from warehouse_sim.render.raster.textures import TextureLibrary
from warehouse_sim.schema import SceneSpec


class SceneGeometry:
    """Parts, meshes and materials of one scene; scenes that differ in light and viewpoints only share it.

    Args:
        context: Where to upload to.
        spec: The scene.
        textures: Gains the textures that the scene names.
        meshes: Gains the meshes of the scene.

    Raises:
        RenderError: The scene names something that it does not hold, or a texture that is not shipped.
    """

    def __init__(
        self, context: moderngl.Context, spec: SceneSpec, textures: TextureLibrary, meshes: MeshLibrary
    ) -> None:
        self._context, self._textures, self._spec = context, textures, spec
        self.materials = MaterialTable(context, spec.materials, textures)
        self.table = build_part_table(spec, self.materials.row)
        self.objects = ObjectIndex.of(self.table)
        self.batches = meshes.require(self.table.meshes)

    def is_of(self, spec: SceneSpec) -> bool:
        """Return whether it would be the same for ``spec``: the very same objects and models, painted alike."""
        mine = self._spec
        if mine.models is not spec.models and not _same_items(mine.models, spec.models):
            return False
        pairs = zip(mine.instances, spec.instances, strict=False)
        same_objects = len(mine.instances) == len(spec.instances) and all(a is b for a, b in pairs)
        return same_objects and spec.painted_like(mine)

    def glow_as(self, spec: SceneSpec) -> None:
        """Let materials emit what they do in ``spec``, of which it is."""
        if spec.materials is not self._spec.materials and spec.materials != self._spec.materials:
            self.materials.release()
            self.materials = MaterialTable(self._context, spec.materials, self._textures)
        self._spec = spec

    def release(self) -> None:
        """Free the device memory; meshes stay in their library."""
        self.materials.release()


def _same_items(a: Mapping[str, object], b: Mapping[str, object]) -> bool:
    return a.keys() == b.keys() and all(a[key] is b[key] for key in a)
