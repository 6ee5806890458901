"""A camera by the one name that it is known by: image size, lens and errors of depth."""

from collections.abc import Mapping
from typing import Any

from warehouse_sim.errors import UnknownNameError
from warehouse_sim.sensors.rgbd.depth import MODELS
from warehouse_sim.sensors.rgbd.depth import PRESETS as DEPTH_PRESETS
from warehouse_sim.sensors.rig.camera import CAMERA_PRESETS


def camera_settings(name: str | None, own: Mapping[str, Any], depth: str | None = None) -> dict[str, Any]:
    """Return what a rig's settings say of a camera: ``camera`` and ``rgbd``.

    Args:
        name: Of a preset; None for a camera of its own numbers.
        own: Settings of the camera that replace the preset's.
        depth: Depth camera or depth model whose errors it has; None for those of the preset, where it has some.

    Raises:
        UnknownNameError: There is no such camera, or no such depth camera.
    """
    if name is not None and name not in CAMERA_PRESETS:
        raise UnknownNameError("camera", name, list(CAMERA_PRESETS))
    settings: dict[str, Any] = {"camera": dict(own) if name is None else {"preset": name, **own}}
    reads = depth or depth_of(name or "")
    if reads is not None:
        settings["rgbd"] = {"depth": _depth_settings(reads)}
    return settings


def depth_of(camera: str) -> str | None:
    """Return the depth camera that a camera preset is a mode of, "d435" of "d435_720p"; None where it has none."""
    return max((name for name in DEPTH_PRESETS if f"{camera}_".startswith(f"{name}_")), key=len, default=None)


def _depth_settings(name: str) -> dict[str, Any]:
    if name in MODELS:
        return {"model": name}
    if name not in DEPTH_PRESETS:
        raise UnknownNameError("depth camera", name, [*DEPTH_PRESETS, *MODELS])
    return {"preset": name}
