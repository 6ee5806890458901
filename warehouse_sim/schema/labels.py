"""What is said of an object in an image: its label, by which faces a truck can take it, and an estimate of its pose."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.geometry.pose import Transform, transform_points
from warehouse_sim.signature import clear_arguments


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


FREE = "free"
"""What is said of a face that a truck can stand before and enter."""
UNDER_A_STACK = "under a stack"
"""Of a face that could be entered, were it not that another pallet stands on this one."""


@dataclass(frozen=True)
class Accessibility:
    """What geometry alone says of one object with pockets."""

    faces: Mapping[str, str]
    """Face ("-x", "+x", "-y", "+y") -> ``FREE``, or why no truck takes it there: "blocked by rack", ..."""
    stacked: bool = False
    """Whether it stands on another pallet or another one on it, itself or its load."""


@dataclass(frozen=True, eq=False)
class ObjectAnnotation:
    """The full label of one target in one observation."""

    instance_id: int
    class_name: str
    obj_id: int
    T_camera_object: Transform
    size: Float[np.ndarray, "3"]
    box_amodal_xyxy: tuple[float, float, float, float]
    """Box of the whole amodal mask, inclusive pixel corners; may leave the image."""
    box_visible_xyxy: tuple[int, int, int, int] | None
    """Box of the visible pixels, inclusive; None when nothing is visible."""
    amodal_mask_offset: tuple[int, int]
    """Column and row of the amodal mask's first pixel in the image; may be negative."""
    amodal_mask: Bool[np.ndarray, "sh sw"]
    """The unoccluded amodal mask, also beyond the image border."""
    pixels_all: int
    """Pixels of the unoccluded amodal mask, inside the image or not."""
    pixels_in_image: int
    """Pixels of the unoccluded amodal mask inside the image."""
    pixels_visible: int
    pixels_valid: int
    """Visible pixels at which the depth sensor gives a reading."""
    hidden_by: dict[str, float] = field(default_factory=dict)
    """Fraction of the amodal mask that each kind of occluder hides: load, rack, traffic, pallet, building, border,
    ..."""
    illuminance: float | None = None
    """Mean illuminance of its visible surface (lx); None = not measured."""

    @property
    def visible_fraction(self) -> float:
        """Visible pixels over unoccluded amodal mask, truncation included."""
        return self.pixels_visible / self.pixels_all if self.pixels_all else 0.0

    @property
    def truncation(self) -> float:
        """Fraction of the amodal mask outside the image."""
        return 1.0 - self.pixels_in_image / self.pixels_all if self.pixels_all else 1.0

    @property
    def occlusion_level(self) -> Literal[0, 1, 2]:
        """KITTI's level by the visible fraction of what lies in the image: 0 from 0.9, 1 from 0.5, 2 below."""
        fraction = self.pixels_visible / self.pixels_in_image if self.pixels_in_image else 0.0
        return 0 if fraction >= 0.9 else 1 if fraction >= 0.5 else 2


@dataclass(frozen=True)
class Agreement:
    """How far an estimator's own hypotheses agree with the pose that it gives; None is not known."""

    spread: float | None = None
    """Weighted RMS distance (m) of the hypotheses' origins from their mean."""
    turn: float | None = None
    """Weighted RMS angle (rad) between the hypotheses and the estimate, under the object's symmetry."""
    moved: float | None = None
    """From the hypotheses' mean to the estimate (m)."""
    margin: float | None = None
    """By how much the verification for the estimate exceeds that for the next best pose; 1 where there is no other."""
    confidence: float | None = None
    """Largest confidence of a hypothesis, 0-1; the estimate's score counts what else speaks for it."""


@clear_arguments
@dataclass(frozen=True, eq=False)
class PoseEstimate:
    """One estimated pose; its first six fields are a row of the BOP pose CSV.

    Example:
        >>> pose = np.eye(4)
        >>> pose[:3, 3] = 0.1, 0.0, 2.5
        >>> ws.PoseEstimate(scene_id=0, image_id=1, obj_id=1, score=0.9, T_camera_object=pose).time
        -1.0
    """

    scene_id: int
    image_id: int
    obj_id: int
    score: float
    T_camera_object: Transform
    time: float = -1.0
    """Seconds for the whole image, -1 = unknown."""
    name: str = ""
    """Name of the CAD geometry; empty = unknown."""
    class_name: str = ""
    """Detection class; empty = unknown."""
    detection: int = -1
    """Which of the image's detections it belongs to, -1 = unknown."""
    predicted_error: float | None = None
    """RMS distance (m) of the surface from its true place that is as likely exceeded as not; None = not calibrated."""
    error_bound: float | None = None
    """The same distance (m) that is exceeded in one case of ten; None = not calibrated."""
    face: PalletFace | None = None
    """Where a fork goes in; None = not estimated."""
    covariance: Float[np.ndarray, "6 6"] | None = None
    """Of the position of the object's origin (m) and a small turn about it (rad), (x, y, z, about x, about y, about z)
    along the axes of the camera frame, as in ROS's PoseWithCovariance; None = unknown."""
    agreement: Agreement | None = None
    """Of the estimator's hypotheses; None = unknown."""
    rejected: bool = False
    """Whether the risk was above what was allowed; then the score is 0, and files of poses leave the estimate out."""
