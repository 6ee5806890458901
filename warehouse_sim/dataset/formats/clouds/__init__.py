"""Point clouds as files that every viewer opens: PLY and PCD, with poses and calibration beside."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.dataset.files.plain import read_transform, take
from warehouse_sim.dataset.files.point_table import SWEEP_FIELDS
from warehouse_sim.dataset.formats.built_in import BuiltIn
from warehouse_sim.dataset.formats.clouds.pcd_cloud import read_pcd_cloud
from warehouse_sim.dataset.formats.clouds.ply_cloud import read_ply_cloud
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.schema import LIDAR, LidarScan, MountedReading
from warehouse_sim.schema.outputs import Output

READERS = {"ply": read_ply_cloud, "pcd": read_pcd_cloud}
"""How clouds are read, by the format's name."""


def stored_sweep(root: Path, name: str, image: ImageRecord) -> MountedReading[LidarScan] | None:
    """Read the sweep of an image with ids, rings and times, and where its sensor was; None where the rig has no LiDAR.

    Raises:
        DatasetError: A file is missing or malformed, or a point is nowhere.
    """
    layout, place = cloud_layout(root, name), (image.split, image.scene_id, image.image_id)
    path = layout.description(*place)
    sensors = take(read_json(path), "sensors", dict, str(path))
    if LIDAR not in sensors:
        return None
    where = f"{path}: {LIDAR}"
    T_camera_lidar = read_transform(take(sensors[LIDAR], "T_camera_sensor", list, where), where)
    cloud = layout.cloud(*place, LIDAR)
    table = READERS[name](cloud)
    if table.dtype != SWEEP_FIELDS:
        raise DatasetError(f"{cloud}: a sweep has the fields {', '.join(SWEEP_FIELDS.names or ())}, in this order")
    points = np.stack([table["x"], table["y"], table["z"]], axis=1)
    if not np.isfinite(points).all():
        raise DatasetError(f"{cloud}: a coordinate is no number; generate the dataset again")
    fields = (np.ascontiguousarray(table[key]) for key in ("intensity", "instance_id", "ring", "time"))
    return MountedReading(T_camera_lidar, LidarScan(points, *fields))


@dataclass(frozen=True)
class CloudLayout:
    """Paths of the clouds of a dataset in one encoding."""

    root: Path
    ending: str
    """Of a cloud's file, which is the format's name, too."""

    def scene(self, split: str, scene_index: int) -> Path:
        """Return the folder of a scene."""
        return self.root / split / f"{scene_index:06d}"

    def cloud(self, split: str, scene_index: int, observation: int, sensor: str) -> Path:
        """Return the cloud of a sensor by its name in the rig."""
        return self.scene(split, scene_index) / f"{observation:06d}_{sensor}.{self.ending}"

    def description(self, split: str, scene_index: int, observation: int) -> Path:
        """Return the poses, the calibration and the classes of an observation."""
        return self.scene(split, scene_index) / f"{observation:06d}.json"


def cloud_layout(root: Path, name: str) -> CloudLayout:
    """Return the paths of the clouds of a dataset; the format's name is the files' ending."""
    return CloudLayout(DatasetLayout(root).format_folder(name), name)


class CloudFormat(BuiltIn):
    """One cloud a sensor and observation, in the sensor's own frame; it is for looking and measuring, not for training.

    Its name, "ply" or "pcd", is the ending of its files, too.
    """

    def sweep(self, root: Path, manifest: Manifest, image: ImageRecord) -> MountedReading[LidarScan] | None:
        """Read the main LiDAR's sweep of an image of a dataset with a manifest; None where the rig has none."""
        return stored_sweep(root, self.name, image)


_NEEDS: tuple[Output, ...] = ("rgb", "depth", "poses")
PLY, PCD = (
    CloudFormat(
        name,
        checks_at=f"warehouse_sim.dataset.formats.clouds.checks:{name.upper()}_CHECKS",
        writer_at=f"warehouse_sim.dataset.formats.clouds.writer:{name.title()}Writer",
        needs=_NEEDS,
        holds=(*_NEEDS, "lidar"),
        counts=("masks",),
    )
    for name in READERS
)
"""Stanford's format of polygons, and that of the Point Cloud Library."""
