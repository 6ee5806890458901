"""Viewpoints: the rig's cameras and the mounts of its other sensors at each place that a scene is observed from."""

from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.geometry.pose import invert
from warehouse_sim.interchange.usd.bindings import bindings
from warehouse_sim.interchange.usd.cameras import add_camera
from warehouse_sim.interchange.usd.lights import add_light, read_light
from warehouse_sim.interchange.usd.placement import place, world_pose
from warehouse_sim.interchange.usd.record import Record, keep
from warehouse_sim.interchange.usd.textures import Textures
from warehouse_sim.schema import SceneSpec, Viewpoint
from warehouse_sim.sensors.rig import RigConfig

_CAMERAS = ("rgbd", "stereo")
"""Kinds of sensors that take the images of the rig's camera; of others the frame is written alone."""
_VEHICLE, _LIGHTS = "vehicle_pose", "vehicle_lights"


def add_viewpoints(stage: Any, root: str, scene: SceneSpec, rig: RigConfig | None, textures: Textures) -> None:
    """Define each viewpoint as a prim in the camera's own axes, and the rig's sensors below it.

    The vehicle's lights shine for their viewpoint alone: they are there, but invisible.

    Raises:
        ConfigError: A sensor sits on a vehicle, but nothing carries the camera.
    """
    pxr = bindings()
    pxr.Geom.Scope.Define(stage, root)
    for number, viewpoint in enumerate(scene.viewpoints):
        path = f"{root}/viewpoint_{number:03d}"
        prim = pxr.Geom.Xform.Define(stage, path).GetPrim()
        place(prim, viewpoint.T_world_camera)
        keep(
            prim,
            {
                "kind": viewpoint.kind,
                "velocity": np.array(viewpoint.velocity),
                "yaw_rate": viewpoint.yaw_rate,
                "time": viewpoint.time,
                "sequence": viewpoint.sequence,
                "target": viewpoint.target,
                "exposure": viewpoint.exposure,
            },
        )
        if viewpoint.visible_request is not None:
            keep(prim, {"visible_request": np.array(viewpoint.visible_request)})
        if viewpoint.T_world_vehicle is not None:
            vehicle = pxr.Geom.Xform.Define(stage, f"{path}/{_VEHICLE}").GetPrim()
            place(vehicle, invert(viewpoint.T_world_camera) @ viewpoint.T_world_vehicle)
        _add_lights(stage, f"{path}/{_LIGHTS}", viewpoint, textures)
        if rig is not None:
            exposure = scene.exposure if viewpoint.exposure is None else viewpoint.exposure
            _add_sensors(stage, path, rig, viewpoint, exposure)


def _add_sensors(stage: Any, path: str, rig: RigConfig, viewpoint: Viewpoint, exposure: float) -> None:
    for name, mounted in rig.mounted().items():
        T_camera_sensor = mounted.T_camera_sensor(viewpoint)
        if mounted.kind in _CAMERAS:
            prim = add_camera(stage, f"{path}/{name}", rig.make_camera(), T_camera_sensor, exposure)
        else:
            prim = bindings().Geom.Xform.Define(stage, f"{path}/{name}").GetPrim()
            place(prim, T_camera_sensor)
        keep(prim, {"sensor": mounted.kind})


def _add_lights(stage: Any, path: str, viewpoint: Viewpoint, textures: Textures) -> None:
    if not viewpoint.lights:
        return
    # Each shifts with the prim above, so what is in the world is turned back by the viewpoint's own pose.
    scope = bindings().Geom.Xform.Define(stage, path)
    place(scope.GetPrim(), invert(viewpoint.T_world_camera))
    scope.CreateVisibilityAttr(bindings().Geom.Tokens.invisible)
    for number, light in enumerate(viewpoint.lights):
        add_light(stage, f"{path}/light_{number:03d}", light, textures)


def read_viewpoint(path: Path, prim: Any, cache: Any) -> Viewpoint:
    """Return the viewpoint of a prim, where a ``UsdGeom.XformCache`` has it.

    Raises:
        DatasetError: A value cannot be used.
    """
    record, vehicle, lights = Record(path, prim), prim.GetChild(_VEHICLE), prim.GetChild(_LIGHTS)
    requested = record.numbers("visible_request", 2) if "visible_request" in record else None
    velocity = record.numbers("velocity", 3)
    return Viewpoint(
        T_world_camera=world_pose(cache, prim),
        kind=record.text("kind"),
        T_world_vehicle=world_pose(cache, vehicle) if vehicle else None,
        velocity=(float(velocity[0]), float(velocity[1]), float(velocity[2])),
        yaw_rate=record.number("yaw_rate"),
        time=record.number("time"),
        sequence=record.whole("sequence") if "sequence" in record else None,
        target=record.whole("target") if "target" in record else None,
        visible_request=None if requested is None else (float(requested[0]), float(requested[1])),
        lights=tuple(read_light(path, child, cache) for child in (lights.GetChildren() if lights else ())),
        exposure=record.number("exposure") if "exposure" in record else None,
    )
