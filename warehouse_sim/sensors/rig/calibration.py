"""How the calibration that a rig states differs from the true one; sampled once a scene, as for another vehicle."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import lens_of
from warehouse_sim.geometry.pose import Transform, invert, make_transform, rotation_x, rotation_y, rotation_z
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.schema import CAMERA, IMU, RIGHT, NominalCalibration, Observation, Viewpoint
from warehouse_sim.sensors.motion import EgoMotion

Stream = Callable[[str], np.random.Generator]
"""Returns the random stream of that name of a scene."""

_MOST = 3.0
"""No error is larger than so many standard deviations: a rig that is farther off is found out and calibrated again."""
_OF_THE_CAMERA = (CAMERA, RIGHT, IMU)
"""What shares the camera's housing and its factory calibration: a rectified pair stays one."""


@dataclass(frozen=True)
@ranged
class CalibrationConfig:
    """Standard deviations of normal errors, cut off at three of them; 0 = stated as it is.

    Focal length and principal point: smartphone and Raspberry Pi cameras that warm up put a target at 10 m off by a few
    millimetres to 5 cm (Elias et al. 2020, Sensors 20(3):643); 1 px of a camera with 450 px is 22 mm there. Places and
    angles: calibrated pairs of LiDAR and camera differ by 10-12 mm on targets about the scene (Tsai et al. 2021,
    arXiv:2103.12287), which at 4 m are 0.15 deg. The others have no source: they are priors.
    """

    focal_fraction: ClassVar[float] = 0.002
    """Of the focal length, as a fraction of it."""
    center_px: ClassVar[float] = 1.0
    """Of each coordinate of the principal point (px)."""
    lens_fraction: ClassVar[float] = 0.02
    """Of what the lens displaces, of a fisheye beyond equidistance, as a fraction of it; nothing without a
    lens."""
    depth_fraction: ClassVar[float] = 0.005
    """Of the scale of depth; on top of the errors of the depth camera's own unit."""
    angle_deg: Annotated[float, Range(0, 20, "deg")] = 0.15
    """Of a sensor's direction about each of its axes (deg), 0-20."""
    place: Annotated[float, Range(0, 1, "m")] = 0.01
    """Of a sensor's place along each of its axes (m), 0-1."""
    time_ms: ClassVar[float] = 10.0
    """Of a sensor's clock against the camera's (ms); it counts while the vehicle moves."""

    def sample(self, sensors: Mapping[str, object], stream: Stream) -> "CalibrationError":
        """Return the errors of one rig.

        Args:
            sensors: Those of the rig by name; each draws from a stream of its own.
            stream: Of the scene.
        """
        rng = stream("nominal camera")
        focal, lens, depth = np.array([self.focal_fraction, self.lens_fraction, self.depth_fraction]) * _normal(rng, 3)
        center = self.center_px * _normal(rng, 2)
        places, offsets = {}, {}
        for name in sensors:
            if name not in _OF_THE_CAMERA:
                mine = stream(f"nominal {name}")
                turn, shift = np.deg2rad(self.angle_deg) * _normal(mine, 3), self.place * _normal(mine, 3)
                places[name] = make_transform(rotation_z(turn[2]) @ rotation_y(turn[1]) @ rotation_x(turn[0]), shift)
                offsets[name] = 1e-3 * self.time_ms * float(_normal(mine, 1)[0])
        factors = 1.0 + float(focal), 1.0 + float(lens), 1.0 + float(depth)
        return CalibrationError(*factors, (float(center[0]), float(center[1])), places, offsets)


@dataclass(frozen=True, eq=False)
class CalibrationError:
    """How far the statements of one rig are off."""

    focal_factor: float
    """Stated over true focal length."""
    lens_factor: float
    """Stated over true displacement of the lens, whose coefficients it is linear in."""
    depth_factor: float
    """Stated over true depth."""
    center_px: tuple[float, float]
    """Stated less true principal point, u and v (px)."""
    T_sensor_nominal: Mapping[str, Transform]
    """Pose of the stated frame of each sensor in its true one."""
    time_offset: Mapping[str, float]
    """Stated less true moment of each sensor (s)."""

    def nominal(self, observation: Observation, viewpoint: Viewpoint) -> NominalCalibration:
        """Return what the rig states of an observation from ``viewpoint``."""
        places = {
            name: self._place(name, observation.readings[name].T_camera_sensor, viewpoint)
            for name in self.T_sensor_nominal
        }
        return NominalCalibration(self.camera(observation.camera), self.depth_factor, places, self.time_offset)

    def camera(self, true: PinholeCamera) -> PinholeCamera:
        """Return the stated intrinsics of a camera."""
        lens = true.distortion
        return replace(
            true,
            fx=true.fx * self.focal_factor,
            fy=true.fy * self.focal_factor,
            cx=true.cx + self.center_px[0],
            cy=true.cy + self.center_px[1],
            distortion=None if lens is None else lens_of([self.lens_factor * k for k in lens.coefficients]),
        )

    def _place(self, name: str, T_camera_sensor: Transform, viewpoint: Viewpoint) -> Transform:
        """Return the nominal pose of a sensor: where the vehicle would have carried it until the stated moment."""
        T_camera_nominal = T_camera_sensor @ self.T_sensor_nominal[name]
        motion = EgoMotion.of(viewpoint)
        if motion is None:
            return T_camera_nominal
        T_world_camera = viewpoint.T_world_camera
        return invert(T_world_camera) @ motion.transform(self.time_offset[name]) @ T_world_camera @ T_camera_nominal


def _normal(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return standard normal numbers, cut off."""
    return np.clip(rng.standard_normal(count), -_MOST, _MOST)
