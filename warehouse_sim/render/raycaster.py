"""Exact rays against the scene's triangles, through Embree."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float32, Int32

from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.optional import require
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


class RayCaster:
    """All parts of a scene in one acceleration structure.

    Args:
        scene: The scene; later changes to it are not seen.

    Raises:
        MissingPackageError: Embree is not installed.
    """

    def __init__(self, scene: SceneSpec) -> None:
        embree = require("embreex.rtcore_scene", "generate", "for LiDAR and ray casting")
        construction = require("embreex.mesh_construction", "generate", "for LiDAR and ray casting")
        vertices, faces, owner, remission = [], [], [], []
        count = 0
        for instance in scene.instances:
            for part in scene.model_of(instance).parts:
                if scene.materials[part.material].opacity < 1.0:
                    continue  # film lets the beam through, as it does the camera's depth and ids
                placed = part.placed()
                vertices.append(transform_points(instance.T_world_object, placed.vertices))
                faces.append(placed.faces + count)
                owner.append(np.full(len(placed.faces), instance.instance_id, np.int32))
                remission.append(np.full(len(placed.faces), scene.materials[part.material].remission, np.float32))
                count += len(placed.vertices)
        mesh = TriangleMesh(np.concatenate(vertices), np.concatenate(faces).astype(np.int32))
        # One extra row answers for rays that hit nothing, whose triangle number is -1.
        self._owner = np.concatenate([*owner, np.zeros(1, np.int32)])
        self._remission = np.concatenate([*remission, np.zeros(1, np.float32)])
        self._normals = np.concatenate([mesh.face_normals(), np.zeros((1, 3))]).astype(np.float32)
        # Robust: no ray slips through the edge that two triangles share.
        self._scene = embree.EmbreeScene(robust=True)
        construction.TriangleMesh(self._scene, mesh.vertices.astype(np.float32), mesh.faces)

    def cast(self, origins: Float[np.ndarray, "n 3"], directions: Float[np.ndarray, "n 3"]) -> RayHits:
        """Return what rays meet first.

        Args:
            origins: Starting points in the world (m).
            directions: Directions in the world, of any length.
        """
        hits = self._scene.run(
            np.ascontiguousarray(origins, np.float32), np.ascontiguousarray(directions, np.float32), output=1
        )
        triangle = hits["primID"]
        return RayHits(
            distance=np.where(triangle >= 0, hits["tfar"], np.float32(np.inf)),
            instance_ids=self._owner[triangle],
            normals=self._normals[triangle],
            remission=self._remission[triangle],
        )
