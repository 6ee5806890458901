"""Any backend behind a lens."""

from collections.abc import Sequence
from types import TracebackType
from typing import Self

import numpy as np
from jaxtyping import Int32

from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.lens.amodal_mask import amodal_mask_through_lens
from warehouse_sim.render.lens.edges import EdgeCaster
from warehouse_sim.render.lens.resample import through_lens
from warehouse_sim.render.lens.source import lens_map
from warehouse_sim.render.renderer import AmodalMask, Capabilities, Renderer
from warehouse_sim.schema import ObjectInstance, RenderBuffers, SceneChange, SceneSpec


class LensRenderer:
    """Draws cameras with a lens by way of a pinhole that another renderer draws; those without are passed on.

    Args:
        renderer: What draws; closing this closes it.
    """

    def __init__(self, renderer: Renderer) -> None:
        self._renderer = renderer
        self._scene: SceneSpec | None = None
        self._edges: EdgeCaster | None = None
        self._seen: tuple[PinholeCamera, bytes, Int32[np.ndarray, "h w"]] | None = None

    @property
    def description(self) -> str:
        """Name and version of what draws."""
        return self._renderer.description

    @property
    def capabilities(self) -> Capabilities:
        """Those of what draws."""
        return self._renderer.capabilities

    def load(self, scene: SceneSpec) -> None:
        """Make ``scene`` the one that is rendered."""
        self._renderer.load(scene)
        change = SceneChange.between(self._scene, scene)
        if change.objects or change.surfaces:
            self._edges = self._seen = None
        self._scene = scene

    def render(self, camera: PinholeCamera, T_world_camera: Transform, normals: bool = False) -> RenderBuffers:
        """Render the loaded scene."""
        if camera.distortion is None:
            return self._renderer.render(camera, T_world_camera, normals)
        lens = lens_map(camera)
        sampled = self._renderer.render(lens.source, T_world_camera, normals)
        shown = through_lens(sampled, lens, self._edge_caster(), T_world_camera)
        self._seen = camera, T_world_camera.tobytes(), shown.instance_ids
        return shown

    def amodal_masks(
        self, camera: PinholeCamera, T_world_camera: Transform, instances: Sequence[ObjectInstance]
    ) -> list[AmodalMask]:
        """Return the unoccluded amodal mask of each of ``instances``; it holds all pixels that show the object."""
        if camera.distortion is None:
            return self._renderer.amodal_masks(camera, T_world_camera, instances)
        lens = lens_map(camera)
        sampled = self._renderer.amodal_masks(lens.source, T_world_camera, instances)
        ids = self._ids_of(camera, T_world_camera)
        return [
            amodal_mask_through_lens(
                amodal_mask,
                lens,
                self._edge_caster(),
                T_world_camera,
                item,
                ids == item.instance_id,
            )
            for amodal_mask, item in zip(sampled, instances, strict=True)
        ]

    def close(self) -> None:
        """Close what draws."""
        self._renderer.close()

    def __enter__(self) -> Self:
        """Return the renderer itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the renderer."""
        self.close()

    def _edge_caster(self) -> EdgeCaster:
        if self._scene is None:
            raise RenderError("no scene is loaded; call load(scene) before drawing")
        if self._edges is None:
            self._edges = EdgeCaster(self._scene)
        return self._edges

    def _ids_of(self, camera: PinholeCamera, T_world_camera: Transform) -> Int32[np.ndarray, "h w"]:
        """Return the ids that a view shows; it is rendered unless it was the last one that was."""
        if self._seen is None or self._seen[:2] != (camera, T_world_camera.tobytes()):
            return self.render(camera, T_world_camera).instance_ids
        return self._seen[2]
