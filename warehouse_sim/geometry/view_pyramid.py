"""The part of space that a camera's image shows."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.geometry.camera import PinholeCamera


@dataclass(frozen=True, eq=False)
class ViewPyramid:
    """Four planes through the optical centre: a point in the camera frame is inside when ``normals @ point >= 0``."""

    normals: Float[np.ndarray, "4 3"]
    """Unit normals that point inwards, camera frame."""

    @classmethod
    def of(cls, camera: PinholeCamera) -> "ViewPyramid":
        """Return the pyramid through the outer borders of the image's outer pixels; behind a lens, one around it."""
        left, right, top, bottom = camera.tangent_bounds()
        planes = np.array([[1.0, 0.0, -left], [-1.0, 0.0, right], [0.0, 1.0, -top], [0.0, -1.0, bottom]])
        return cls(planes / np.linalg.norm(planes, axis=1, keepdims=True))

    def touches(
        self, centre: Float[np.ndarray, "n 3"], radius: Float[np.ndarray, " n"], near: float = 0.0
    ) -> Bool[np.ndarray, " n"]:
        """Return which spheres reach into the pyramid beyond ``near``; keeps a few that just miss its edges.

        Args:
            centre: Centres in the camera frame (m).
            radius: Radii (m).
            near: Distance of the near plane (m).
        """
        inside = (centre @ self.normals.T >= -radius[:, None]).all(axis=1)
        return inside & (centre[:, 2] >= near - radius)

    def touches_boxes(
        self, centre: Float[np.ndarray, "n 3"], half_edges: Float[np.ndarray, "n 3 3"], near: float = 0.0
    ) -> Bool[np.ndarray, " n"]:
        """Return which boxes reach into the pyramid beyond ``near``; keeps a few that just miss its edges.

        Args:
            centre: Centres in the camera frame (m).
            half_edges: For each box three vectors from its centre to the middles of its sides, camera frame (m).
            near: Distance of the near plane (m).
        """
        reach = np.abs(half_edges @ self.normals.T).sum(axis=1)
        inside = (centre @ self.normals.T >= -reach).all(axis=1)
        return inside & (centre[:, 2] + np.abs(half_edges[..., 2]).sum(axis=1) >= near)
