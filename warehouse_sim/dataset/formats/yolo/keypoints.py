"""Key points of a pallet: the corners of the pocket openings on the side that looks at the camera most.

They are named as one sees them who stands before that side: pockets from left to right, of each the corners top left,
top right, bottom right, bottom left. Pallets look the same after half a turn; points of a named side would not.
"""

from collections import defaultdict
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Float32

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.schema import Pocket

CORNERS = 4
"""Of a pocket's opening."""
_MIRRORED = (1, 0, 3, 2)
"""Which corner takes the place of each in the mirror."""
_BEFORE = 0.02
"""Metres by which a surface must be nearer than a corner to hide it."""
_NEAR = 0.05
OUTSIDE, HIDDEN, VISIBLE = 0, 1, 2
"""Flags of a point: not in the image, in it and hidden, seen."""


def points_of(pockets: Sequence[Pocket]) -> int:
    """Return how many key points the fullest side of an object has."""
    return CORNERS * max((len(side) for side in _sides(pockets)), default=0)


def mirrored(count: int) -> list[int]:
    """Return for each of ``count`` points the one that takes its place in the mirror."""
    pockets = count // CORNERS
    return [CORNERS * (pockets - 1 - pocket) + corner for pocket in range(pockets) for corner in _MIRRORED]


def key_points(
    pockets: Sequence[Pocket],
    T_camera_object: Transform,
    camera: PinholeCamera,
    depth: Float32[np.ndarray, "h w"],
    count: int,
) -> Float[np.ndarray, "count 3"]:
    """Return u, v (px, pixel centres at integers) and flag of each key point; zeros where there is none.

    Args:
        pockets: Those of the object.
        T_camera_object: Its pose.
        camera: That of the image.
        depth: True depth of the image (m), 0 = nothing there.
        count: Points of a label; sides with fewer pockets fill the first places.
    """
    points = np.zeros((count, 3))
    corners = transform_points(T_camera_object, _facing_corners(pockets, invert(T_camera_object)[:3, 3]))
    for index, corner in enumerate(corners[:count]):
        place = _place(corner, camera)
        if place is not None:
            column, row = np.clip(np.rint(place), 0, [camera.width - 1, camera.height - 1]).astype(int)
            before = 0.0 < depth[row, column] < corner[2] - _BEFORE
            points[index] = *place, HIDDEN if before else VISIBLE
    return points


def _place(corner: Float[np.ndarray, " 3"], camera: PinholeCamera) -> Float[np.ndarray, " 2"] | None:
    """Return where a point of the camera frame is in the image; None if it is not."""
    if corner[2] < _NEAR:
        return None
    x, y = corner[:2] / corner[2]
    # Before the lens: its formula brings far points back into the image.
    left, right, top, bottom = camera.tangent_bounds()
    if not (left <= x <= right and top <= y <= bottom):
        return None
    u, v = camera.project(corner)
    inside = -0.5 <= u <= camera.width - 0.5 and -0.5 <= v <= camera.height - 0.5
    return np.array([u, v]) if inside else None


def _facing_corners(pockets: Sequence[Pocket], eye: Float[np.ndarray, " 3"]) -> Float[np.ndarray, "n 3"]:
    """Return the corners (m, object frame) on the side that faces the eye most; none if all look away."""
    best, most = np.zeros((0, 3)), 0.0
    for side in _sides(pockets):
        towards = eye - np.mean([pocket.T_object_pocket[:3, 3] for pocket in side], axis=0)
        cosine = float(-side[0].T_object_pocket[:3, 0] @ towards / max(np.linalg.norm(towards), 1e-9))
        if cosine > most:
            best, most = np.concatenate([_opening(pocket) for pocket in side]), cosine
    return best


def _sides(pockets: Sequence[Pocket]) -> list[list[Pocket]]:
    """Return the pockets of each side, from left to right as seen from before it."""
    by_face: dict[str, list[Pocket]] = defaultdict(list)
    for pocket in pockets:
        by_face[pocket.face].append(pocket)
    return [sorted(side, key=_rightness) for _, side in sorted(by_face.items())]


def _rightness(pocket: Pocket) -> float:
    """Return how far right a pocket lies (m): inwards is ahead and z is up, so that its y points to the left."""
    return -float(pocket.T_object_pocket[:3, 3] @ pocket.T_object_pocket[:3, 1])


def _opening(pocket: Pocket) -> Float[np.ndarray, "4 3"]:
    _, width, height = pocket.size / 2.0
    corners = np.array([[0.0, width, height], [0.0, -width, height], [0.0, -width, -height], [0.0, width, -height]])
    return transform_points(pocket.T_object_pocket, corners)
