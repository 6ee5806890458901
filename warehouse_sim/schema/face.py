"""What a forklift needs of a pallet: where its fork goes in, and how sure that is."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.pose import Transform, transform_points


@dataclass(frozen=True, eq=False)
class PalletFace:
    """The side of a pallet that is approached, with its pockets; all of it seen, none of it from a catalog's name."""

    T_camera_dock: Transform
    """Dock frame: origin midway between the pockets in the face plane, x inwards, y to the left, z up."""
    covariance: Float[np.ndarray, "6 6"]
    """Of a small motion of the dock frame in itself: rotation vector (rad), then shift (m)."""
    pockets: Float[np.ndarray, "p 2"]
    """Where the openings' centres are along y and z of the dock frame (m), from right to left."""
    pockets_covariance: Float[np.ndarray, "p 2 2"]
    """Of each centre in the dock frame, beside the dock frame's own (m^2)."""
    pocket_sizes: Float[np.ndarray, "p 2"]
    """Clear width and height of each (m)."""
    pocket_sizes_covariance: Float[np.ndarray, "p 2 2"]
    """Of each width and height (m^2)."""
    size: Float[np.ndarray, " 2"]
    """Width and height of the whole face (m)."""
    size_covariance: Float[np.ndarray, "2 2"]
    """Of both (m^2)."""

    @property
    def pocket_centres(self) -> Float[np.ndarray, "p 3"]:
        """Centres of the openings (camera frame, m), from right to left."""
        return transform_points(self.T_camera_dock, np.pad(self.pockets, ((0, 0), (1, 0))))

    @property
    def pocket_centres_covariance(self) -> Float[np.ndarray, "p 3 3"]:
        """Of the centres (camera frame, m^2), what is unsure of the dock frame included."""
        found = []
        for centre, own in zip(self.pockets, self.pockets_covariance, strict=True):
            # A point p of a frame that moves by (a, b) in itself goes to p + a x p + b.
            jacobian = np.hstack([-_cross(np.array([0.0, *centre])), np.eye(3)])
            found.append(jacobian @ self.covariance @ jacobian.T + np.pad(own, ((1, 0), (1, 0))))
        R = self.T_camera_dock[:3, :3]
        return R @ np.stack(found) @ R.T

    @property
    def direction(self) -> Float[np.ndarray, " 3"]:
        """Unit vector along which the fork enters (camera frame)."""
        return np.asarray(self.T_camera_dock[:3, 0])

    @property
    def direction_covariance(self) -> Float[np.ndarray, "3 3"]:
        """Of the direction (camera frame, rad^2); of rank two."""
        jacobian = -self.T_camera_dock[:3, :3] @ _cross(np.array([1.0, 0.0, 0.0]))
        return np.asarray(jacobian @ self.covariance[:3, :3] @ jacobian.T)


def _cross(v: Float[np.ndarray, " 3"]) -> Float[np.ndarray, "3 3"]:
    """Return the matrix that maps w to v x w."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
