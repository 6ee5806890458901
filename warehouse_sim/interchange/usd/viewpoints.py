"""Viewpoints: the rig's cameras and the mounts of its other sensors at each place that a scene is observed from."""

from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Fisheye
from warehouse_sim.geometry.pose import Transform, invert, make_transform
from warehouse_sim.interchange.usd.bindings import bindings, place, world_pose
from warehouse_sim.interchange.usd.lights import add_light, read_light
from warehouse_sim.interchange.usd.record import Record, keep
from warehouse_sim.interchange.usd.textures import Textures
from warehouse_sim.schema import SceneSpec, Viewpoint
from warehouse_sim.sensors.rig import RigConfig

_WIDTH = 0.36
"""Of the image, in tenths of a metre (UsdGeom.Camera: tenths of a scene unit)."""
_OPENGL = make_transform(np.diag([1.0, -1.0, -1.0]))
_CLIPPING = (0.05, 1000.0)
"""Least and greatest distance drawn (m)."""


def add_camera(stage: Any, path: str, camera: PinholeCamera, T_parent_camera: Transform, exposure: float) -> Any:
    """Define ``camera`` and return its prim.

    Args:
        stage: Where.
        path: Of the prim.
        camera: Its intrinsics.
        T_parent_camera: Its pose in the prim above, in OpenCV's axes.
        exposure: Factor from luminance (cd/m^2) to linear image values.
    """
    pxr = bindings()
    shown = pxr.Geom.Camera.Define(stage, path)
    place(shown.GetPrim(), T_parent_camera @ _OPENGL)
    per_pixel = _WIDTH / camera.width
    focal = camera.fx * per_pixel
    vertical = focal / camera.fy  # of a pixel, which need not be square
    shown.CreateFocalLengthAttr(focal)
    shown.CreateHorizontalApertureAttr(_WIDTH)
    shown.CreateVerticalApertureAttr(camera.height * vertical)
    # The middle of the image off the axis, to the right and upwards.
    shown.CreateHorizontalApertureOffsetAttr(((camera.width - 1) / 2 - camera.cx) * per_pixel)
    shown.CreateVerticalApertureOffsetAttr((camera.cy - (camera.height - 1) / 2) * vertical)
    shown.CreateClippingRangeAttr(pxr.Gf.Vec2f(*_CLIPPING))
    if exposure > 0.0:
        shown.CreateExposureAttr(np.log2(exposure))
    if camera.distortion is not None:
        _add_lens(shown.GetPrim(), camera)
    return shown.GetPrim()


def _add_lens(prim: Any, camera: PinholeCamera) -> None:
    pxr, lens = bindings(), camera.distortion
    assert lens is not None
    kinds = pxr.Sdf.ValueTypeNames
    fisheye = isinstance(lens, Fisheye)
    model, schema = ("opencvFisheye", "OpenCvFisheye") if fisheye else ("opencvPinhole", "OpenCvPinhole")
    prim.AddAppliedSchema(f"OmniLensDistortion{schema}API")
    prim.CreateAttribute("omni:lensdistortion:model", kinds.Token, custom=False).Set(model)
    names = ("k1", "k2", "k3", "k4") if fisheye else ("k1", "k2", "p1", "p2", "k3")
    numbers = dict(zip(names, lens.coefficients, strict=True))
    # Pixel centres are whole numbers here; there the image begins at 0.
    numbers |= {"fx": camera.fx, "fy": camera.fy, "cx": camera.cx + 0.5, "cy": camera.cy + 0.5}
    for name, value in numbers.items():
        prim.CreateAttribute(f"omni:lensdistortion:{model}:{name}", kinds.Float, custom=False).Set(float(value))
    size = prim.CreateAttribute(f"omni:lensdistortion:{model}:imageSize", kinds.Int2, custom=False)
    size.Set(pxr.Gf.Vec2i(camera.width, camera.height))


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
        kind=record.get("kind", str),
        T_world_vehicle=world_pose(cache, vehicle) if vehicle else None,
        velocity=(float(velocity[0]), float(velocity[1]), float(velocity[2])),
        yaw_rate=record.get("yaw_rate", float),
        time=record.get("time", float),
        sequence=record.get("sequence", int, None),
        target=record.get("target", int, None),
        visible_request=None if requested is None else (float(requested[0]), float(requested[1])),
        lights=tuple(read_light(path, child, cache) for child in (lights.GetChildren() if lights else ())),
        exposure=record.get("exposure", float, None),
    )
