"""An observation that has not been stored, with the labels and arrays that a reader gives of a stored one."""

from collections.abc import Iterable
from functools import cached_property
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float32, UInt8

from warehouse_sim.dataset.formats.bop.labels import camera_row, pose_row, visibility_row
from warehouse_sim.dataset.formats.bop.tables import BopRows, read_image
from warehouse_sim.dataset.frame_files import ObservationFiles
from warehouse_sim.dataset.objects import ObjectInfo, object_info
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.schema import LidarScan, MountedReading, ObjectModel, Observation


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
        """Return the colour image."""
        return self._files.observation.rgbd.rgb

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

    def mask(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Return the mask of a target's whole amodal mask, as far as it lies in the image."""
        return self._files.targets[gt_index].mask

    def sweep(self, image: ImageRecord) -> MountedReading[LidarScan] | None:
        """Return the main LiDAR's mounted sweep; None without one."""
        found = self._files.observation
        return None if found.lidar is None else MountedReading(found.T_camera_lidar, found.lidar)
