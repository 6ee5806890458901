"""What the recipe in a manifest says of the sensors, as far as a dataset's files depend on it."""

import re
from dataclasses import dataclass
from typing import Any

from warehouse_sim.dataset.plain import LENGTHS, NUMBERS, PIXELS, Span, shown, take, take_if_given
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion

_LIDAR_NAME = re.compile("[a-z][a-z0-9]{0,60}")
_FOCAL = Span(1e-3, 1e6)
_COEFFICIENTS = ("k1", "k2", "p1", "p2", "k3")


@dataclass(frozen=True)
class RecordedRig:
    """The sensors of a dataset; one whose recipe says nothing about sensors has a camera and a LiDAR."""

    camera: PinholeCamera | None = None
    """The camera with its lens; None where the recipe does not tell its size and focal length."""
    distortion: Distortion | None = None
    """The lens; None where it does nothing."""
    baseline: float | None = None
    """From the left to the right camera (m); None without a right camera."""
    matched: bool = False
    """Whether the disparity that matching finds is stored."""
    clean: bool = False
    """Whether clean depth and colour are stored beside the readings."""
    lidars: tuple[str, ...] = ()
    """Names of the LiDARs beside the main one; they are parts of folder names."""


def recorded_rig(recipe: dict[str, Any], where: str = "recipe") -> RecordedRig:
    """Read what a resolved recipe says of the sensors.

    Args:
        recipe: As the manifest holds it.
        where: For the messages.

    Raises:
        DatasetError: A setting is of another type or out of range, or the name of a LiDAR is no word.
    """
    sensors = take_if_given(recipe, "sensors", dict, where) or {}
    where = f"{where}: sensors"
    right = take_if_given(sensors, "right", dict, where)
    camera = take_if_given(sensors, "camera", dict, where) or {}
    names = take_if_given(sensors, "lidars", dict, where) or {}
    for name in names:
        if not _LIDAR_NAME.fullmatch(name):
            raise DatasetError(f"{where}: the name of a LiDAR must be small letters and digits, found {shown(name)}")
    distortion = _distortion(camera, f"{where}: camera")
    return RecordedRig(
        camera=_camera(camera, distortion, f"{where}: camera"),
        distortion=distortion,
        baseline=None if right is None else take(right, "baseline", float, f"{where}: right", LENGTHS),
        matched=right is not None and right.get("matching") is not None,
        clean=bool(take_if_given(sensors, "clean", bool, where)),
        lidars=tuple(names),
    )


def _camera(settings: dict[str, Any], distortion: Distortion | None, where: str) -> PinholeCamera | None:
    if not {"width", "height", "focal_px"} <= set(settings):
        return None
    width, height = (take(settings, key, int, where, PIXELS) for key in ("width", "height"))
    focal = take(settings, "focal_px", float, where, _FOCAL)
    cx, cy = (take_if_given(settings, key, float, where, NUMBERS) for key in ("cx", "cy"))
    centred = (width - 1) / 2 if cx is None else cx, (height - 1) / 2 if cy is None else cy
    return PinholeCamera(width, height, focal, focal, *centred, distortion)


def _distortion(settings: dict[str, Any], where: str) -> Distortion | None:
    given = take_if_given(settings, "distortion", dict, where) or {}
    values = [take_if_given(given, key, float, f"{where}.distortion", NUMBERS) or 0.0 for key in _COEFFICIENTS]
    return Distortion(*values) if any(values) else None
