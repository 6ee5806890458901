"""A scene record's entry of an observation: viewpoint, light, paired variant, calibration, what each target shows."""

from dataclasses import dataclass, field, fields, replace
from typing import Annotated, Any

import numpy as np

from warehouse_sim.config import fields_to_plain
from warehouse_sim.dataset.files.record import Place, Record, Rigid, Whole, camera_row, read_camera_row
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.level_view import lean
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.ranges import Range
from warehouse_sim.schema import Conditions, Light, NominalCalibration, ObjectAnnotation, Observation


def light_row(light: Light) -> dict[str, Any]:
    """Return plain data of a light; of a distribution the name of its file, and how it is turned."""
    row = dict(vars(light))
    distribution, along = row.pop("distribution"), row.pop("along")
    return row if distribution is None else row | {"distribution": distribution.name, "along": along}


_Lux = Annotated[float, Range(0, 1e9, "lx")]
_Part = Annotated[float, Range(0, 1)]
_Speed = Annotated[float, Range(-100, 100)]
_Moment = Annotated[float, Range(0, 1e6, "s")]
_LARGEST_LEAN = np.deg2rad(2.0) + 1e-9
"""Rounding on the way through poses must not turn 2 deg into more (rad)."""


@dataclass(frozen=True)
class _Stated(Record):
    """The calibration that a rig states."""

    camera: dict[str, Any]
    depth_factor: Annotated[float, Range(0.1, 10)]
    T_camera_sensor: dict[str, Rigid]
    time_offset: dict[str, Annotated[float, Range(-1e3, 1e3, "s")]]


def _nominal_row(nominal: NominalCalibration) -> dict[str, Any]:
    places, offsets = dict(nominal.T_camera_sensor), dict(nominal.time_offset)
    return _Stated(camera_row(nominal.camera), nominal.depth_factor, places, offsets).row()


def _read_nominal(data: Any, where: str) -> NominalCalibration:
    stated = _Stated.read(data, where)
    if stated.T_camera_sensor.keys() != stated.time_offset.keys():
        raise DatasetError(f"{where}: T_camera_sensor and time_offset must name the same sensors")
    camera = read_camera_row(stated.camera, f"{where}: camera")
    return NominalCalibration(camera, stated.depth_factor, stated.T_camera_sensor, stated.time_offset)


@dataclass(frozen=True)
class RecordedTarget(Record):
    """One labelled target of an observation, measured."""

    instance_id: Whole
    visible_fraction: _Part
    """Visible pixels over the whole amodal mask, truncation included."""
    distance: Place
    """From the camera to the object's origin (m)."""
    pixels_all: Whole
    """Pixels of the whole amodal mask, inside the image or not."""
    hidden_by: dict[str, _Part]
    """Fraction of the amodal mask that each kind of occluder hides."""
    illuminance: _Lux | None
    """Mean illuminance of its visible surface (lx)."""


@dataclass(frozen=True, eq=False)
class RecordedObservation(Record):
    """One observation of a scene; without a ``kind`` nothing is stored of a viewpoint."""

    T_world_camera: Rigid
    kind: str = ""
    """Vehicle and mounting of the camera."""
    time: _Moment = 0.0
    """Since the drive began (s)."""
    sequence: Whole | None = None
    """Number of the drive within the scene."""
    target: Whole | None = None
    """Instance id of the object that the viewpoint was chosen for."""
    visible_request: tuple[_Part, _Part] | None = None
    """Visible fraction that was requested of it."""
    T_world_vehicle: Rigid | None = None
    """What carries the camera; None = nothing."""
    velocity: tuple[_Speed, _Speed, _Speed] = (0.0, 0.0, 0.0)
    """Of the carrier's origin in the world (m/s)."""
    yaw_rate: _Speed = 0.0
    """Of the carrier, counter-clockwise seen from above (rad/s)."""
    vehicle_lights: tuple[dict[str, Any], ...] = ()
    """Lights that the vehicle carries."""
    T_camera_lidar: Rigid | None = field(default=None, metadata={"omitted": True})
    """True pose of a main LiDAR that leans, whose points formats may turn; None where it does not."""
    conditions: Conditions = field(default_factory=Conditions)
    targets: tuple[RecordedTarget, ...] = ()
    """In order of instance id."""
    nominal: NominalCalibration | None = field(
        default=None, metadata={"omitted": True, "from_plain": _read_nominal, "to_plain": _nominal_row}
    )
    """What the rig says of its calibration; None = the ground truth."""

    def to_plain(self) -> dict[str, Any]:
        """Return what is read back."""
        row = fields_to_plain(self)
        return (
            row
            if self.kind
            else {key: value for key, value in row.items() if key not in (*OF_VIEWPOINT, "vehicle_lights")}
        )


OF_VIEWPOINT = tuple(item.name for item in fields(RecordedObservation))[1:9]
"""What a viewpoint has under the same names."""


def lidar_leans(T_world_lidar: Transform) -> bool:
    """Return whether a LiDAR leans by more than 2 deg, so that its z axis passes for vertical no longer.

    Real KITTI's own is mounted up to about one degree off.
    """
    return lean(T_world_lidar) > _LARGEST_LEAN


def recorded_observation(observation: Observation) -> RecordedObservation:
    """Return what the scene record holds of an observation."""
    view, leans = observation.viewpoint, observation.lidar is not None and lidar_leans(observation.T_world_lidar)
    seen = RecordedObservation(
        observation.T_world_camera,
        T_camera_lidar=observation.T_camera_lidar if leans else None,
        conditions=observation.conditions,
        targets=tuple(_recorded_target(item) for item in observation.annotations if item.pixels_visible > 0),
        nominal=observation.nominal,
    )
    if view is None:
        return seen
    told: dict[str, Any] = {name: getattr(view, name) for name in OF_VIEWPOINT}
    return replace(seen, **told, vehicle_lights=tuple(light_row(light) for light in view.lights))


def _recorded_target(item: ObjectAnnotation) -> RecordedTarget:
    return RecordedTarget(
        item.instance_id,
        item.visible_fraction,
        float(np.linalg.norm(item.T_camera_object[:3, 3])),
        item.pixels_all,
        item.hidden_by,
        item.illuminance,
    )
