"""Which visible pixels are seen through film, by rays: renderers leave film out of depth and instance ids."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Bool

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import ObjectInstance, RenderBuffers, SceneSpec

_BEFORE = 1e-4
"""Film is before a surface when it is nearer by this (m)."""


class FilmCaster:
    """All film of a scene: parts whose material has an opacity below 1.

    Args:
        scene: The scene; later changes to it are not seen.

    Raises:
        MissingPackageError: Embree is not installed.
    """

    def __init__(self, scene: SceneSpec) -> None:
        film = {name: replace(item, opacity=1.0) for name, item in scene.materials.items() if item.opacity < 1.0}
        parts = {
            name: tuple(part for part in model.parts if part.material in film) for name, model in scene.models.items()
        }
        models = {name: replace(scene.models[name], parts=found) for name, found in parts.items() if found}
        instances = tuple(item for item in scene.instances if item.model in models)
        # Painted opaque and alone, film is what rays meet.
        alone = replace(scene, models=models, materials=film, instances=instances)
        self._caster = RayCaster(alone) if instances else None

    def image(
        self,
        camera: PinholeCamera,
        T_world_camera: Transform,
        buffers: RenderBuffers,
        targets: Sequence[ObjectInstance],
    ) -> Bool[np.ndarray, "h w"] | None:
        """Return the pixels in which one of ``targets`` is seen through film; None for a scene without film.

        Args:
            camera: With which intrinsics the scene was rendered.
            T_world_camera: From where.
            buffers: What was rendered.
            targets: Objects that are requested; other pixels are False.
        """
        if self._caster is None:
            return None
        through = np.isin(buffers.instance_mask, [item.instance_id for item in targets])
        rows, columns = np.nonzero(through)
        on_plane = camera.tangents_at(columns, rows)
        directions = on_plane @ T_world_camera[:3, :2].T + T_world_camera[:3, 2]
        hits = self._caster.cast(np.broadcast_to(T_world_camera[:3, 3], directions.shape), directions)
        # Directions have length 1 along the optical axis, so that distances are depths.
        through[rows, columns] = hits.distance < buffers.depth[rows, columns] - _BEFORE
        return through
