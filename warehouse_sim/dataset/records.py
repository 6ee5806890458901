"""What a reader says of an image and of each target that is labelled in it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from jaxtyping import Bool, Float32, UInt8

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform

NO_POSE: Transform = np.full((4, 4), np.nan)
"""The pose of a target of which the dataset says only where it is in the image."""
NO_POSE.setflags(write=False)


@dataclass(frozen=True, eq=False)
class TargetRecord:
    """The label of one target in one image."""

    gt_index: int
    """Position in the image's labels; names its masks."""
    obj_id: int
    instance_id: int
    """Number in the scene record; 0 when the dataset does not say."""
    T_camera_object: Transform
    """Its pose; ``NO_POSE`` when the dataset does not say."""
    visible_fraction: float
    """Visible pixels over the whole amodal mask, truncation included."""
    pixels_visible: int
    box_visible_xyxy: tuple[float, float, float, float]
    """Inclusive pixel corners of the visible part."""
    box_amodal_xyxy: tuple[float, float, float, float]
    """Inclusive pixel corners of the whole amodal mask; may leave the image."""
    pixels_valid: int
    """Pixels of the amodal mask in the image, hidden or not, with a depth reading."""
    pixels_all: int
    """Pixels of the whole amodal mask, inside the image or not."""
    geometry: ObjectInfo | None = None
    """Its own, where the objects of a class have no CAD and differ; else it is that of its obj_id."""

    def info(self, objects: Mapping[int, ObjectInfo]) -> ObjectInfo:
        """Return its own geometry, else that of its obj_id among ``objects``."""
        return self.geometry or objects[self.obj_id]

    @property
    def has_pose(self) -> bool:
        """Whether the dataset says where the target is in space, not in the image only."""
        return bool(np.isfinite(self.T_camera_object).all())


@dataclass(frozen=True, eq=False)
class ImageRecord:
    """One image of a split."""

    split: str
    scene_id: int
    image_id: int
    camera: PinholeCamera
    T_world_camera: Transform
    """Where the camera was; in the world of the camera itself when the dataset does not say."""
    depth_scale: float
    """Millimetres a step of the depth file."""
    targets: tuple[TargetRecord, ...]
    calibrated: bool = True
    """Whether the camera is known; else only its size is, and its focal length is a guess for drawing."""


class ImagePixels(Protocol):
    """What gives the arrays of an image: a reader of files, or an observation that has none."""

    def rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Return the colour image."""

    def depth(self, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        """Return the depth image: metres along the optical axis, 0 = no reading."""

    def mask_visible(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Return the mask of a target's visible pixels."""
