"""Observations that are stored nowhere, as those that are read back from files."""

from collections.abc import Iterable
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float32, UInt8

from warehouse_sim.dataset.files.image_io import depth_steps, fitting_depth
from warehouse_sim.dataset.formats.bop.tables import BopRows, camera_row, pose_row, read_image, visibility_row
from warehouse_sim.dataset.formats.observation_files import MILLIMETRES, ObservationFiles
from warehouse_sim.dataset.objects import ObjectInfo, object_info
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.schema import CAMERA, LidarScan, MountedReading, ObjectModel, Observation
from warehouse_sim.schema.outputs import Output


def as_stored(observation: Observation) -> Observation:
    """Return the observation with the depth that files of millimetres hold; all else is stored as it is.

    Raises:
        DatasetError: A depth does not fit into 16 bits.
    """
    where = f"depth, scene {observation.scene_index}, observation {observation.observation_index}"
    read = _metres(depth_steps(observation.rgbd.depth, MILLIMETRES, where))
    clean = _metres(depth_steps(fitting_depth(observation.buffers.depth, MILLIMETRES), MILLIMETRES, where))
    mounted = observation.readings[CAMERA]
    camera = MountedReading(mounted.T_camera_sensor, replace(observation.rgbd, depth=read))
    return replace(
        observation,
        readings={**observation.readings, CAMERA: camera},
        buffers=replace(observation.buffers, depth=clean),
        level=None if observation.level is None else as_stored(observation.level),
    )


def _metres(steps: np.ndarray) -> Float32[np.ndarray, "h w"]:
    found: Float32[np.ndarray, "h w"] = steps.astype(np.float32) * np.float32(1.0 / MILLIMETRES)
    return found


class ObservedImage:
    """One observation as ``DatasetReader`` would give it.

    Args:
        observation: With depth as it is stored (``as_stored``).
    """

    def __init__(self, observation: Observation) -> None:
        self._files = ObservationFiles(observation)

    @cached_property
    def record(self) -> ImageRecord:
        """Camera and labels: the rows that are written of it, read again, so that they are the same to the bit."""
        item, targets = self._files.observation, self._files.targets
        where = f"scene {item.scene_index}, observation {item.observation_index}"
        rows = BopRows(
            (camera_row(item), where),
            ([pose_row(target.annotation) for target in targets], where),
            ([visibility_row(target, item.rgbd.depth) for target in targets], where),
        )
        size = item.camera.width, item.camera.height
        return read_image("train", (item.scene_index, item.observation_index), size, rows)

    def rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Return the colour image.

        Raises:
            DatasetError: The recipe leaves it out.
        """
        found = self._files.observation.rgbd.rgb
        if not found.size:
            raise DatasetError("the recipe makes no rgb; add it to sensors.outputs")
        return found

    def depth(self, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        """Return the depth image: metres along the optical axis, 0 = no reading."""
        return self._files.observation.rgbd.depth

    def mask_visible(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Return the mask of a target's visible pixels."""
        return self._files.targets[gt_index].mask_visible


class ObservedDataset(ObservedImage):
    """One observation as a dataset of its own, which has been stored nowhere.

    Args:
        observation: What was read.
        models: Geometries of what is labelled in it.
    """

    root = Path("(rendered, not stored)")
    """What messages call it."""
    has_depth = True

    def __init__(self, observation: Observation, models: Iterable[ObjectModel]) -> None:
        super().__init__(observation)
        labelled = {target.annotation.obj_id for target in self._files.targets}
        self._models = {model.obj_id: model for model in models if model.obj_id in labelled}

    @cached_property
    def objects(self) -> dict[int, ObjectInfo]:
        """The CAD geometries of what is labelled, by obj_id."""
        return {number: object_info(model, self.root) for number, model in self._models.items()}

    def leaves_out(self, output: Output) -> bool:
        """Return whether the output was not made."""
        return output == "rgb" and not self._files.observation.rgbd.rgb.size

    def mask(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Return the mask of a target's whole amodal mask, as far as it lies in the image."""
        return self._files.targets[gt_index].mask

    def sweep(self, image: ImageRecord) -> MountedReading[LidarScan] | None:
        """Return the main LiDAR's mounted sweep; None without one."""
        found = self._files.observation
        return None if found.lidar is None else MountedReading(found.T_camera_lidar, found.lidar)
