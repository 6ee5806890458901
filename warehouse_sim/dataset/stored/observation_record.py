"""A scene record's entry of an observation: viewpoint, light, paired variant, calibration, what each target shows."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from warehouse_sim.dataset.files.plain import (
    FRACTIONS,
    PIXELS,
    PLACES,
    WHOLE,
    Span,
    lens_row,
    plain,
    read_lens,
    read_transform,
    take,
    take_if_given,
    take_numbers,
)
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.level_view import lean
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.schema import Conditions, Light, NominalCalibration, ObjectAnnotation, Observation


def light_row(light: Light) -> dict[str, Any]:
    """Return plain data of a light; of a distribution the name of its file, and how it is turned."""
    row = dict(vars(light))
    distribution, along = row.pop("distribution"), row.pop("along")
    return row if distribution is None else row | {"distribution": distribution.name, "along": along}


_FOCAL = Span(1e-3, 1e7)
_CENTER = Span(-1e6, 1e6)
_FACTOR = Span(0.1, 10.0)
_SECONDS = Span(-1e3, 1e3)


def nominal_row(nominal: NominalCalibration) -> dict[str, Any]:
    """Return plain data of a nominal calibration, but for arrays."""
    camera = nominal.camera
    intrinsics = {name: getattr(camera, name) for name in ("width", "height", "fx", "fy", "cx", "cy")}
    return {
        "camera": intrinsics | lens_row(camera),
        "depth_factor": nominal.depth_factor,
        "T_camera_sensor": dict(nominal.T_camera_sensor),
        "time_offset": dict(nominal.time_offset),
    }


def read_nominal(data: Any, where: str) -> NominalCalibration:
    """Read a nominal calibration.

    Raises:
        DatasetError: An entry is missing or malformed.
    """
    camera, inner = take(data, "camera", dict, where), f"{where}: camera"
    lens = read_lens(camera, inner)
    focal = [take(camera, name, float, inner, _FOCAL) for name in ("fx", "fy")]
    center = [take(camera, name, float, inner, _CENTER) for name in ("cx", "cy")]
    size = [take(camera, name, int, inner, PIXELS) for name in ("width", "height")]
    places, offsets = take(data, "T_camera_sensor", dict, where), take(data, "time_offset", dict, where)
    if places.keys() != offsets.keys():
        raise DatasetError(f"{where}: T_camera_sensor and time_offset must name the same sensors")
    return NominalCalibration(
        camera=PinholeCamera(size[0], size[1], focal[0], focal[1], center[0], center[1], lens),
        depth_factor=take(data, "depth_factor", float, where, _FACTOR),
        T_camera_sensor={name: read_transform(T, f"{where}: T_camera_sensor: {name}") for name, T in places.items()},
        time_offset={name: take(offsets, name, float, f"{where}: time_offset", _SECONDS) for name in offsets},
    )


_TIMES = Span(0.0, 1e6)
_LUX = Span(0.0, 1e9)
_EXPOSURES = Span(-100.0, 100.0)
_SPEEDS = Span(-100.0, 100.0)
_LARGEST_LEAN = np.deg2rad(2.0) + 1e-9
"""Rounding on the way through poses must not turn 2 deg into more (rad)."""


@dataclass(frozen=True)
class RecordedTarget:
    """One labelled target of an observation, measured."""

    instance_id: int
    visible_fraction: float
    """Visible pixels over the whole amodal mask, truncation included."""
    distance: float
    """From the camera to the object's origin (m)."""
    pixels_all: int
    """Pixels of the whole amodal mask, inside the image or not."""
    hidden_by: dict[str, float]
    """Fraction of the amodal mask that each kind of occluder hides."""
    illuminance: float | None
    """Mean illuminance of its visible surface (lx)."""


@dataclass(frozen=True, eq=False)
class RecordedObservation:
    """One observation of a scene."""

    T_world_camera: Transform
    conditions: Conditions = field(default_factory=Conditions)
    kind: str = ""
    """Vehicle and mounting of the camera."""
    time: float = 0.0
    """Since the drive began (s)."""
    sequence: int | None = None
    """Number of the drive within the scene."""
    T_world_vehicle: Transform | None = None
    """What carries the camera; None = nothing."""
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Of the carrier's origin in the world (m/s)."""
    yaw_rate: float = 0.0
    """Of the carrier, counter-clockwise seen from above (rad/s)."""
    target: int | None = None
    """Instance id of the object that the viewpoint was chosen for."""
    visible_request: tuple[float, float] | None = None
    """Visible fraction that was requested of it."""
    targets: tuple[RecordedTarget, ...] = field(default=())
    """In order of instance id."""
    nominal: NominalCalibration | None = None
    """What the rig says of its calibration; None = the ground truth."""
    T_camera_lidar: Transform | None = None
    """True pose of a main LiDAR that leans, whose points formats may turn; None where it does not."""


def lidar_leans(T_world_lidar: Transform) -> bool:
    """Return whether a LiDAR leans by more than 2 deg, so that its z axis passes for vertical no longer.

    Real KITTI's own is mounted up to about one degree off.
    """
    return lean(T_world_lidar) > _LARGEST_LEAN


def observation_row(observation: Observation) -> dict[str, Any]:
    """Return plain data of one observation for the scene record."""
    row: dict[str, Any] = {"T_world_camera": observation.T_world_camera}
    view = observation.viewpoint
    if view is not None:
        row |= {"kind": view.kind, "time": view.time, "sequence": view.sequence, "target": view.target}
        row |= {"visible_request": view.visible_request, "T_world_vehicle": view.T_world_vehicle}
        row |= {"velocity": view.velocity, "yaw_rate": view.yaw_rate}
        row["vehicle_lights"] = [light_row(light) for light in view.lights]
    if observation.lidar is not None and lidar_leans(observation.T_world_lidar):
        row["T_camera_lidar"] = observation.T_camera_lidar
    row["conditions"] = vars(observation.conditions)
    row["targets"] = [_target_row(item) for item in observation.annotations if item.pixels_visible > 0]
    if observation.nominal is not None:
        row["nominal"] = nominal_row(observation.nominal)
    plain_row: dict[str, Any] = plain(row)
    return plain_row


def read_observation(data: Any, where: str) -> RecordedObservation:
    """Read one observation of a scene record; without a viewpoint that it was chosen by, defaults stand for it.

    Raises:
        DatasetError: An entry is missing or malformed.
    """
    T_world_camera = read_transform(take(data, "T_world_camera", list, where), where)
    request = None
    if take_if_given(data, "visible_request", list, where) is not None:
        low, high = take_numbers(data, "visible_request", 2, where, FRACTIONS).tolist()
        request = low, high
    vehicle = take_if_given(data, "T_world_vehicle", list, where)
    x, y, z = take_numbers(data, "velocity", 3, where, _SPEEDS).tolist() if "velocity" in data else (0.0, 0.0, 0.0)
    nominal = take_if_given(data, "nominal", dict, where)
    lidar = take_if_given(data, "T_camera_lidar", list, where)
    return RecordedObservation(
        T_world_camera=T_world_camera,
        conditions=_read_conditions(take(data, "conditions", dict, where), f"{where}: conditions"),
        kind=take_if_given(data, "kind", str, where) or "",
        time=take_if_given(data, "time", float, where, _TIMES) or 0.0,
        sequence=take_if_given(data, "sequence", int, where, WHOLE),
        T_world_vehicle=None if vehicle is None else read_transform(vehicle, where),
        velocity=(x, y, z),
        yaw_rate=take_if_given(data, "yaw_rate", float, where, _SPEEDS) or 0.0,
        target=take_if_given(data, "target", int, where, WHOLE),
        visible_request=request,
        targets=tuple(_read_target(item, where) for item in take(data, "targets", list, where)),
        nominal=None if nominal is None else read_nominal(nominal, f"{where}: nominal"),
        T_camera_lidar=None if lidar is None else read_transform(lidar, f"{where}: T_camera_lidar"),
    )


def _read_conditions(data: Any, where: str) -> Conditions:
    absent = take(data, "absent", list, where)
    return Conditions(
        lighting=take(data, "lighting", str, where),
        floor_lux=take_if_given(data, "floor_lux", float, where, _LUX),
        exposure_ev=take_if_given(data, "exposure_ev", float, where, _EXPOSURES),
        variant=take(data, "variant", str, where),
        variant_group=take_if_given(data, "variant_group", int, where, WHOLE),
        sensor=take_if_given(data, "sensor", str, where) or "",
        absent=tuple(int(number) for number in take_numbers(data, "absent", len(absent), where, WHOLE)),
    )


def _target_row(item: ObjectAnnotation) -> dict[str, Any]:
    return {
        "instance_id": item.instance_id,
        "visible_fraction": item.visible_fraction,
        "distance": float(np.linalg.norm(item.T_camera_object[:3, 3])),
        "pixels_all": item.pixels_all,
        "hidden_by": item.hidden_by,
        "illuminance": item.illuminance,
    }


def _read_target(data: Any, where: str) -> RecordedTarget:
    hidden_by = take(data, "hidden_by", dict, where)
    return RecordedTarget(
        instance_id=take(data, "instance_id", int, where, WHOLE),
        visible_fraction=take(data, "visible_fraction", float, where, FRACTIONS),
        distance=take(data, "distance", float, where, PLACES),
        pixels_all=take(data, "pixels_all", int, where, WHOLE),
        hidden_by={kind: take(hidden_by, kind, float, f"{where}: hidden_by", FRACTIONS) for kind in hidden_by},
        illuminance=take_if_given(data, "illuminance", float, where, _LUX),
    )
