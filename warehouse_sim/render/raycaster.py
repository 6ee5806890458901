"""Exact rays against the scene's triangles, through Embree."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float32, Int32

from warehouse_sim.render.embree import PlacedMeshes
from warehouse_sim.schema import SceneSpec


@dataclass(frozen=True, eq=False)
class RayHits:
    """The first surface on each ray."""

    distance: Float32[np.ndarray, " n"]
    """In units of the ray's direction; infinite when nothing is hit."""
    instance_ids: Int32[np.ndarray, " n"]
    """0 when nothing is hit."""
    normals: Float32[np.ndarray, "n 3"]
    """Unit outward normals in the world; zero when nothing is hit."""
    remission: Float32[np.ndarray, " n"]
    """Of the surface's material; zero when nothing is hit."""
    materials: Int32[np.ndarray, " n"]
    """Number of the surface's material among ``RayCaster.materials``; -1 when nothing is hit."""
    pieces: Int32[np.ndarray, " n"]
    """Number of the part of its model that the surface belongs to, over all models; -1 when nothing is hit."""


class RayCaster:
    """All solid parts of a scene, each model's triangles held once.

    Film, that is materials with an opacity below 1, lets rays through, as it does the camera's depth and ids.

    Args:
        scene: The scene; later changes to it are not seen.

    Raises:
        MissingPackageError: Embree is not installed.
    """

    def __init__(self, scene: SceneSpec) -> None:
        solid = {
            name: [part for part in scene.models[name].parts if scene.materials[part.material].opacity >= 1.0]
            for name in {instance.model: None for instance in scene.instances}
        }
        group_of = {name: number for number, name in enumerate(name for name, parts in solid.items() if parts)}
        placed = [instance for instance in scene.instances if instance.model in group_of]
        self._meshes = PlacedMeshes(
            [[part.placed() for part in solid[name]] for name in group_of],
            [(group_of[instance.model], instance.T_world_object) for instance in placed],
        )
        # One more row answers for rays that hit nothing, whose place is -1.
        self._owner = np.array([*(instance.instance_id for instance in placed), 0], np.int32)
        rotations = [instance.T_world_object[:3, :3] for instance in placed]
        self._rotation = np.array([*rotations, np.zeros((3, 3))], np.float32)
        self._first_piece = np.zeros(len(placed) + 1, np.int64)
        starts = np.cumsum([0, *(len(solid[name]) for name in group_of)])
        self._first_piece[:-1] = [starts[group_of[instance.model]] for instance in placed]
        paints = [part.material for name in group_of for part in solid[name]]
        self._remission = np.array([*(scene.materials[paint].remission for paint in paints), 0.0], np.float32)
        self.materials = tuple(dict.fromkeys(paints))
        """Names of the materials that rays can meet."""
        number_of = {name: number for number, name in enumerate(self.materials)}
        self._material = np.array([*(number_of[paint] for paint in paints), -1], np.int32)

    def cast(self, origins: Float[np.ndarray, "n 3"], directions: Float[np.ndarray, "n 3"]) -> RayHits:
        """Return what rays meet first.

        Args:
            origins: Starting points in the world (m).
            directions: Directions in the world, of any length.
        """
        hits = self._meshes.cast(origins, directions)
        missed = hits.place < 0
        normals = np.einsum("nij,nj->ni", self._rotation[hits.place], hits.normal)
        length = np.sqrt(np.einsum("ni,ni->n", normals, normals))[:, None]
        piece = np.where(missed, -1, self._first_piece[hits.place] + hits.piece)
        return RayHits(
            distance=hits.distance,
            instance_ids=self._owner[hits.place],
            normals=np.divide(normals, length, out=np.zeros_like(normals), where=length > 0),
            remission=self._remission[piece],
            materials=self._material[piece],
            pieces=piece.astype(np.int32),
        )
