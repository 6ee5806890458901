"""Exact rays against the scene's triangles, through Embree."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Float32, Int, Int32

from warehouse_sim.render.embree import PacketHits, PlacedMeshes
from warehouse_sim.schema import SceneSpec

_PAST_END = 1.001
"""Where rays to an end are cut off, so that rounding at the end itself decides as without a cut."""


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

    Film, that is materials with an opacity below 1, lets rays through, as it does the camera's depth and instance
    masks.

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
        rotations = np.array([*(instance.T_world_object[:3, :3] for instance in placed), np.zeros((3, 3))], np.float32)
        # By row and column, as whole columns are worked on.
        self._rotation = np.ascontiguousarray(rotations.transpose(1, 2, 0))
        self._first_piece = np.full(len(placed) + 1, -1, np.intp)
        starts = np.cumsum([0, *(len(solid[name]) for name in group_of)])
        self._first_piece[:-1] = [starts[group_of[instance.model]] for instance in placed]
        # The materials of one look after another: objects of one model share triangles, and each has its paint.
        looks = {item.look: [item.material_of(part) for part in solid[item.model]] for item in placed}
        first = dict(zip(looks, np.cumsum([0, *map(len, looks.values())]).tolist(), strict=False))
        self._first_paint = np.array([*(first[item.look] for item in placed), -1], np.intp)
        paints = [paint for look in looks.values() for paint in look]
        self._remission = np.array([*(scene.materials[paint].remission for paint in paints), 0.0], np.float32)
        self.materials = tuple(dict.fromkeys(paints))
        """Names of the materials that rays can meet."""
        number_of = {name: number for number, name in enumerate(self.materials)}
        self._material = np.array([*(number_of[paint] for paint in paints), -1], np.int32)

    def cast(
        self, origins: Float[np.ndarray, "n 3"], directions: Float[np.ndarray, "n 3"], *, coherent: bool = False
    ) -> RayHits:
        """Return what rays meet first.

        Args:
            origins: Starting points in the world (m).
            directions: Directions in the world, of any length.
            coherent: Whether rays that follow one another mostly go the same way, which makes them faster.
        """
        return self._described(self._meshes.cast(origins, directions, coherent=coherent))

    def arrives(self, origins: Float[np.ndarray, "n 3"], end: Float[np.ndarray, " 3"]) -> Bool[np.ndarray, " n"]:
        """Return whether nothing lies between each of ``origins`` and their one ``end`` (m, world)."""
        return self._meshes.cast(origins, end - origins, reach=_PAST_END).distance >= 1.0

    def cast_before(
        self, origins: Float[np.ndarray, "n 3"], directions: Float[np.ndarray, "n 3"], reach: Float32[np.ndarray, " n"]
    ) -> tuple[Int[np.ndarray, " m"], RayHits]:
        """Return which rays meet anything nearer than ``reach``, and what these meet first.

        Args:
            origins: Starting points in the world (m).
            directions: Directions in the world, of any length; rays that follow one another mostly go the same way.
            reach: In units of the directions.
        """
        hits = self._meshes.cast(origins, directions, coherent=True)
        near = np.flatnonzero(hits.distance < reach)
        of_near = (hits.distance[near], hits.place[near], hits.piece[near], hits.triangle[near])
        return near, self._described(PacketHits(*of_near, np.take(hits.normal.T, near, axis=1).T))

    def _described(self, hits: PacketHits) -> RayHits:
        """Return what packets of rays met in terms of the scene."""
        place = hits.place.astype(np.intp)  # -1 = the last row
        piece, paint = self._first_piece[place], self._first_paint[place]
        piece += hits.piece
        paint += hits.piece
        return RayHits(
            distance=hits.distance,
            instance_ids=self._owner[place],
            normals=self._world_normals(place, hits.normal),
            remission=self._remission[paint],
            materials=self._material[paint],
            pieces=piece.astype(np.int32),
        )

    def _world_normals(
        self, place: Int[np.ndarray, " n"], normal: Float32[np.ndarray, "n 3"]
    ) -> Float32[np.ndarray, "n 3"]:
        """Return unit normals in the world, component by component; zero where ``place`` is -1."""
        turned = np.empty((3, len(place)), np.float32)
        for row, component in zip(self._rotation, turned, strict=True):
            np.multiply(row[0][place], normal[:, 0], out=component)
            component += row[1][place] * normal[:, 1]
            component += row[2][place] * normal[:, 2]
        length = np.sqrt(turned[0] * turned[0] + turned[1] * turned[1] + turned[2] * turned[2])
        turned /= np.maximum(length, np.finfo(np.float32).tiny)
        return turned.T
