"""One labelled object of an observation."""

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.pose import Transform, transform_points

Box = tuple[float, float, float, float]


class LabelledObject:
    """An object with its label in one observation; masks are read when they are used.

    Args:
        reader: The dataset.
        image: The observation.
        target: The label.
    """

    def __init__(self, reader: DatasetReader, image: ImageRecord, target: TargetRecord) -> None:
        self._reader, self._image, self._target = reader, image, target

    def __repr__(self) -> str:
        seen = f"{self.visible_fraction:.0%} visible"
        at = f", {np.linalg.norm(self.T_camera_object[:3, 3]):.2f} m away" if self.has_pose else ", no pose"
        return f"<{self.name or 'object'} {self.instance_id}: {seen}{at}>"

    @property
    def name(self) -> str:
        """Name of its CAD geometry, such as "epal1"; empty where the dataset does not say."""
        return "" if self._info is None else self._info.name

    @property
    def class_name(self) -> str:
        """Its detection class, such as "pallet"; empty where the dataset does not say."""
        return "" if self._info is None else self._info.class_name

    @property
    def obj_id(self) -> int:
        """Number of its CAD geometry, as in BOP."""
        return self._target.obj_id

    @property
    def instance_id(self) -> int:
        """Its number in the scene; counted from 1 in the observation where the dataset does not number instances."""
        return instance_number(self._image, self._target)

    @property
    def visible_fraction(self) -> float:
        """Visible pixels over the pixels of the amodal mask, what is outside the image included."""
        return self._target.visible_fraction

    @property
    def has_pose(self) -> bool:
        """Whether the dataset holds its pose."""
        return self._target.has_pose

    @property
    def T_camera_object(self) -> Transform:
        """Its pose in the camera frame (4 x 4, m; x right, y down, z forward).

        Raises:
            DatasetError: The dataset holds no pose of it.
        """
        if not self.has_pose:
            raise DatasetError(
                f"{self._reader.root}: holds no pose of {self._where}; "
                "read the dataset in a format with poses, such as bop or kitti"
            )
        return self._target.T_camera_object.copy()

    @property
    def size(self) -> Float[np.ndarray, " 3"]:
        """Edge lengths of its box (m) along its own axes.

        Raises:
            DatasetError: The dataset does not say it.
        """
        info = self._info
        if info is None or not np.all(info.size > 0):
            raise DatasetError(
                f"{self._reader.root}: holds no size of {self._where}; "
                "read the dataset in a format with 3D boxes, such as bop or kitti"
            )
        return np.array(info.size, dtype=float)

    @property
    def box_3d(self) -> Float[np.ndarray, "8 3"]:
        """Corners of its box in the camera frame (m).

        Raises:
            DatasetError: The dataset holds no pose or no size of it.
        """
        return transform_points(self.T_camera_object, box_corners(self.size))

    @property
    def box_2d(self) -> Box:
        """Box of its visible part: left, top, right, bottom (px), inclusive."""
        left, top, right, bottom = (float(edge) for edge in self._target.box_visible_xyxy)
        return left, top, right, bottom

    @property
    def box_amodal_2d(self) -> Box:
        """Box of its amodal mask: left, top, right, bottom (px), inclusive; it may leave the image."""
        left, top, right, bottom = (float(edge) for edge in self._target.box_amodal_xyxy)
        return left, top, right, bottom

    @property
    def mask(self) -> Bool[np.ndarray, "h w"]:
        """Its visible pixels.

        Raises:
            DatasetError: The dataset holds no mask of it.
        """
        return self._reader.mask_visible(self._image, self._target.gt_index)

    @property
    def amodal_mask(self) -> Bool[np.ndarray, "h w"]:
        """All its pixels in the image, as if nothing stood before it.

        Raises:
            DatasetError: The dataset holds no such mask of it.
        """
        return self._reader.mask(self._image, self._target.gt_index)

    @property
    def _info(self) -> ObjectInfo | None:
        return self._target.geometry or self._reader.objects.get(self._target.obj_id)

    @property
    def _where(self) -> str:
        image = self._image
        return f"object {self._target.gt_index} of scene {image.scene_id}, image {image.image_id}"


def instance_number(image: ImageRecord, target: TargetRecord) -> int:
    """Return the number of a label in its scene; in its image, from 1, where some label has none."""
    numbered = all(item.instance_id > 0 for item in image.targets)
    return target.instance_id if numbered else target.gt_index + 1
