"""The calibration that a rig states, as the scene record holds it."""

from typing import Any

from warehouse_sim.dataset.files.lens_row import lens_row, read_lens
from warehouse_sim.dataset.files.plain import PIXELS, Span, read_transform, take
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.schema import NominalCalibration

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
