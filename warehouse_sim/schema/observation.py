"""One captured sensor set: what was read, from where, under which circumstances, and the labels."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, cast

import numpy as np
from jaxtyping import Float32, Int32

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.ranges import Range
from warehouse_sim.schema.labels import ObjectAnnotation
from warehouse_sim.schema.readings import (
    CAMERA,
    LIDAR,
    RIGHT,
    LidarScan,
    MountedReading,
    NominalCalibration,
    Reading,
    RenderBuffers,
    RgbdReading,
    StereoReading,
)
from warehouse_sim.schema.scene import Viewpoint


@dataclass(frozen=True)
class Conditions:
    """Under which circumstances an observation was made: what was measured, and which paired variant it is."""

    lighting: str = "nominal"
    """Name of the light preset."""
    floor_lux: Annotated[float, Range(0, 1e9, "lx")] | None = None
    """Mean illuminance of the aisle's floor (lx); None = not measured."""
    exposure_ev: Annotated[float, Range(-100, 100)] | None = None
    """Exposure value at ISO 100 that the camera was set to."""
    variant: str = "base"
    """What was changed against the first paired variant, in a word."""
    variant_group: Annotated[int, Range(0, 2**31 - 1)] | None = None
    """Observations of a scene with the same number differ in the variant only; None = no paired variants."""
    absent: tuple[Annotated[int, Range(0, 2**31 - 1)], ...] = ()
    """Instance ids of the scene's objects that are taken away in this variant."""
    sensor: str = ""
    """Name of the camera that a recipe drew for the scene; empty = the rig's only one."""


@dataclass(frozen=True, eq=False)
class Observation:
    """One captured sensor set with its labels."""

    scene_index: int
    observation_index: int
    camera: PinholeCamera
    T_world_camera: Transform
    readings: Mapping[str, MountedReading[Reading]]
    """What each sensor of the rig read, by its name there; the camera's is always among them."""
    buffers: RenderBuffers
    """The clean ground truth behind the camera's reading."""
    annotations: tuple[ObjectAnnotation, ...]
    """Targets whose amodal mask touches the image, in order of instance id."""
    viewpoint: Viewpoint | None = None
    """Where it was taken from."""
    conditions: Conditions = Conditions()
    """Under which circumstances."""
    object_coordinates: Float32[np.ndarray, "h w 3"] | None = None
    """Place of each visible target pixel in its object's box, 0-1 along each edge, NaN elsewhere; None = not wanted."""
    class_numbers: Int32[np.ndarray, "h w"] | None = None
    """Number of the class that each pixel shows, 0 = none; None = not wanted."""
    nominal: NominalCalibration | None = None
    """What the rig says of its calibration; None = the ground truth."""
    level: "Observation | None" = None
    """The same moment through the level virtual camera at the same place, for formats that know no other; None where
    the camera itself serves, or none was requested."""

    @property
    def rgbd(self) -> RgbdReading:
        """What the rig's camera read."""
        return cast(RgbdReading, self.readings[CAMERA].reading)

    @property
    def lidar(self) -> LidarScan | None:
        """The sweep of the main LiDAR; None where the rig has none."""
        return cast(LidarScan, self.readings[LIDAR].reading) if LIDAR in self.readings else None

    @property
    def T_camera_lidar(self) -> Transform:
        """Pose of the main LiDAR, which the rig must have, in the camera frame."""
        return self.readings[LIDAR].T_camera_sensor

    @property
    def T_world_lidar(self) -> Transform:
        """Pose of the main LiDAR, which the rig must have, in the world."""
        return self.T_world_camera @ self.T_camera_lidar

    @property
    def lidars(self) -> dict[str, MountedReading[LidarScan]]:
        """The sweeps of the LiDARs beside the main one, by name."""
        return {
            name: MountedReading(item.T_camera_sensor, item.reading)
            for name, item in self.readings.items()
            if name != LIDAR and isinstance(item.reading, LidarScan)
        }

    @property
    def stereo(self) -> StereoReading | None:
        """What the second camera adds; None where the rig has none."""
        found = self.readings[RIGHT].reading if RIGHT in self.readings else None
        return found if isinstance(found, StereoReading) else None

    def with_reading(
        self, name: str, reading: Reading | None, T_camera_sensor: Transform | None = None
    ) -> "Observation":
        """Return the observation with one sensor's reading replaced, added, or left out where it is None.

        Args:
            name: Of the sensor.
            reading: What it read instead.
            T_camera_sensor: Where it was; by default where it is now, or at the camera.
        """
        others = {key: item for key, item in self.readings.items() if key != name}
        if reading is None:
            return replace(self, readings=others)
        if T_camera_sensor is None:
            T_camera_sensor = self.readings[name].T_camera_sensor if name in self.readings else np.eye(4)
        return replace(self, readings=others | {name: MountedReading(T_camera_sensor, reading)})
