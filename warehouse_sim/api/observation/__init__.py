"""One observation of a dataset, whose arrays are read when they are used."""

import logging
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float32, Int32, UInt8, UInt16

from warehouse_sim.api.arguments import checked
from warehouse_sim.api.observation.labelled_object import LabelledObject, instance_number
from warehouse_sim.dataset.files.image_io import encode_rgb
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.dataset.viewing.overlay import colorize_depth
from warehouse_sim.dataset.viewing.panels import labelled_picture
from warehouse_sim.errors import DatasetError, InputError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.clouds import depth_to_cloud
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.schema import LidarScan, MountedReading
from warehouse_sim.signature import clear_call

if TYPE_CHECKING:
    from warehouse_sim.api.observation.open3d_view import Open3dView

log = logging.getLogger(__name__)
_UNPLACED = np.eye(4)


class Observation:
    """What the sensors read at one moment, with its labels; ``Dataset`` yields it.

    Arrays are numpy, lengths are metres, axes of the camera are those of OpenCV (x right, y down, z forward). Each
    array is read when it is first used and then kept; what the dataset lacks is an error that says so.

    Example:
        >>> obs = ws.Dataset("out")[0]
        >>> obs.rgb.dtype, obs.rgb.shape == (*obs.depth.shape, 3), obs.points.shape[1]
        (dtype('uint8'), True, 3)
        >>> for o in obs.objects:
        ...     assert o.mask.shape == obs.depth.shape and o.T_camera_object.shape == (4, 4)
        >>> picture = obs.draw("look.png")
    """

    @clear_call
    def __init__(self, reader: DatasetReader, image: ImageRecord) -> None:
        if not isinstance(reader, DatasetReader) or not isinstance(image, ImageRecord):
            raise InputError("an Observation comes from a dataset: write ws.Dataset(folder)[0]")
        self._reader, self._image = reader, image

    def __repr__(self) -> str:
        camera, count = self.camera, len(self._image.targets)
        return (
            f"<Observation scene {self.scene_id}, image {self.image_id} ({self.split}): "
            f"{camera.width} x {camera.height} px, {count} object{'' if count == 1 else 's'}>"
        )

    def _repr_png_(self) -> bytes:
        """Show itself in a notebook."""
        return encode_rgb(self.draw())

    @property
    def scene_id(self) -> int:
        """Number of its scene."""
        return self._image.scene_id

    @property
    def image_id(self) -> int:
        """Its number in the scene."""
        return self._image.image_id

    @property
    def split(self) -> str:
        """The split that its scene belongs to."""
        return self._image.split

    @property
    def camera(self) -> PinholeCamera:
        """Intrinsics of the image: ``K``, ``width``, ``height``, ``fx``, ``fy``, ``cx``, ``cy``, ``distortion``.

        Raises:
            DatasetError: The dataset holds no calibration of it.
        """
        return self._image.camera

    @property
    def T_world_camera(self) -> Transform | None:
        """Pose of the camera in the world (4 x 4, m; z up, floor at z = 0); None where the dataset does not say."""
        T = self._image.T_world_camera
        return None if np.array_equal(T, _UNPLACED) else T.copy()

    @cached_property
    def rgb(self) -> UInt8[np.ndarray, "h w 3"]:
        """The colour image."""
        return self._reader.rgb(self._image)

    @cached_property
    def depth(self) -> Float32[np.ndarray, "h w"]:
        """The depth image: metres along the optical axis, 0 = no reading.

        Raises:
            DatasetError: The dataset holds no depth images.
        """
        return self._reader.depth(self._image)

    @cached_property
    def points(self) -> Float32[np.ndarray, "n 3"]:
        """Points (m) in the camera frame of all pixels with a depth reading, row by row.

        Raises:
            DatasetError: The dataset holds no depth images or no calibration.
        """
        if not self._image.calibrated:
            raise DatasetError(
                f"{self._reader.root}: holds no calibration of scene {self.scene_id}, image {self.image_id}; "
                "points need the camera's intrinsics"
            )
        return depth_to_cloud(self.depth, self.camera)[0].astype(np.float32)

    @cached_property
    def normals(self) -> Float32[np.ndarray, "h w 3"]:
        """The unit normal of the surface that each pixel shows, in the camera frame; zeros where there is nothing.

        Raises:
            DatasetError: The dataset holds none; it is generated with ``outputs=["default", "normals"]``.
        """
        return self._reader.normals(self._image)

    @cached_property
    def object_coordinates(self) -> Float32[np.ndarray, "h w 3"]:
        """Where visible target pixels lie in the boxes of their objects, 0-1 along each edge; NaN elsewhere.

        ``(value - 0.5) * size`` is the place in the object frame (m), but for the little that leaves the box.

        Raises:
            DatasetError: The dataset holds none; it is generated with ``outputs=["default", "object_coordinates"]``.
        """
        return self._reader.object_coordinates(self._image)

    @cached_property
    def class_mask(self) -> UInt16[np.ndarray, "h w"]:
        """The class that each pixel shows, of all objects: a key of ``mask_classes``; 0 = nothing.

        Raises:
            DatasetError: The dataset holds none; it is generated with ``outputs=["default", "class_mask"]``.
        """
        return self._reader.class_mask(self._image)

    @cached_property
    def mask_classes(self) -> dict[int, str]:
        """The class that each value of ``class_mask`` stands for; those of your own objects differ between scenes."""
        return self._reader.mask_classes(self._image)

    @property
    def lidar(self) -> Float32[np.ndarray, "n 3"] | None:
        """Points (m) of the main LiDAR's sweep in its own axes (x ahead, y left, z up); None without one."""
        return None if self._sweep is None else self._sweep.reading.points

    @property
    def lidar_intensity(self) -> Float32[np.ndarray, " n"] | None:
        """Intensity of each point of ``lidar``, 0-1; None without one."""
        return None if self._sweep is None else self._sweep.reading.intensity

    @property
    def T_camera_lidar(self) -> Transform | None:
        """Pose of the main LiDAR in the camera frame (4 x 4, m); None without one."""
        return None if self._sweep is None else self._sweep.T_camera_sensor.copy()

    @cached_property
    def objects(self) -> tuple[LabelledObject, ...]:
        """The objects with a label, in the order of the dataset's labels."""
        return tuple(LabelledObject(self._reader, self._image, target) for target in self._image.targets)

    @cached_property
    def instance_mask(self) -> Int32[np.ndarray, "h w"]:
        """``instance_id`` of the labelled object that each pixel shows, 0 = none.

        Raises:
            DatasetError: The dataset holds no masks.
        """
        numbers = np.zeros((self.camera.height, self.camera.width), np.int32)
        for target in self._image.targets:
            mask = self._reader.mask_visible(self._image, target.gt_index)
            numbers[mask] = instance_number(self._image, target)
        return numbers

    @checked
    def draw(self, path: str | Path | None = None) -> UInt8[np.ndarray, "h w 3"]:
        """Draw its labels on the image: masks, boxes of poses, class, distance (m) and visible fraction.

        Args:
            path: PNG file to write; none by default.

        Returns:
            The picture; small images are enlarged. Without a colour image the depth image is shown, with
            a warning.

        Raises:
            OutputError: The file cannot be written.
            DatasetError: The dataset holds neither colour nor depth of it.
        """
        if path is not None and Path(path).suffix.lower() != ".png":
            raise InputError(f"draw writes PNG: {str(path)!r} must end in .png")
        picture = labelled_picture(self._reader.objects, self._image, self._base(), self._masks())
        if path is not None:
            make_folder(Path(path).parent)
            write_bytes(Path(path), encode_rgb(picture))
        return picture

    def to_open3d(self) -> "Open3dView":
        """Return it as Open3D knows it: ``rgbd``, ``camera`` and ``cloud``; requires the extra ``open3d``.

        Raises:
            MissingPackageError: Open3D is not installed.
            DatasetError: The dataset holds no colour, no depth or no calibration.
        """
        from warehouse_sim.api.observation.open3d_view import open3d_view

        return open3d_view(self)

    @cached_property
    def _sweep(self) -> MountedReading[LidarScan] | None:
        return self._reader.sweep(self._image)

    def _base(self) -> UInt8[np.ndarray, "h w 3"]:
        try:
            return self.rgb
        except DatasetError as problem:
            if not self._reader.has_depth:
                raise
            log.warning("%s; the labels are drawn on the depth image", problem)
            return colorize_depth(self.depth)

    def _masks(self) -> dict[int, np.ndarray]:
        found = {}
        for target in self._image.targets:
            try:
                found[target.gt_index] = self._reader.mask_visible(self._image, target.gt_index)
            except DatasetError:  # boxes are drawn without masks
                continue
        return found
