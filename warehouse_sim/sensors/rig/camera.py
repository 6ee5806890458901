"""The camera of a rig: image size, focal length and lens."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Annotated, Any

import numpy as np

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError, UnknownNameError, shown, suggestion
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion, Fisheye
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.sensors.rgbd.depth import MODELS
from warehouse_sim.sensors.rgbd.depth import PRESETS as DEPTH_PRESETS

_MOST_PIXELS = 4096 * 4096
"""An image has at most so many; some ten arrays of its size are in memory at once."""
_LEAST_VIEW_DEG, _WIDEST_DEG = 2.0, 85.0
"""Least field of view along the longer side, and largest angle of what a pinhole shows to its optical axis."""
_LEAST_HFOV, _WIDEST_HFOV = 5.0, 170.0
"""Angles across an image (deg) that a recipe can give: radians are below them."""


@dataclass(frozen=True)
@ranged
class CameraConfig:
    """A camera; in YAML also the name of a preset, or ``preset`` with what differs from it.

    ``hfov_deg``, the angle between the left and the right border (deg, 5-170), may stand in place of ``focal_px``.
    """

    width: Annotated[int, Range(16, 8192, "px")] = 1224
    """Image width (px), 16-8,192."""
    height: Annotated[int, Range(16, 8192, "px")] = 370
    """Image height (px), 16-8,192."""
    focal_px: Annotated[float, Range(50, 20_000, "px")] = 721.5377
    """Focal length (px), 50-20,000."""
    cx: Annotated[float, Range(-8192, 16_384, "px")] | None = None
    """Principal point u (px), 0 at the centre of the first column, -8,192 to 16,384; by default the centre's."""
    cy: Annotated[float, Range(-8192, 16_384, "px")] | None = None
    """Principal point v (px), 0 at the centre of the first row, -8,192 to 16,384; by default the centre's."""
    distortion: Distortion | None = None
    """Brown-Conrady k1, k2, p1, p2, k3 of the lens as OpenCV has them; null = the image is rectified."""
    fisheye: Fisheye | None = None
    """Instead of ``distortion``: Kannala-Brandt k1, k2, k3, k4 of a fisheye as OpenCV has them; {} = equidistant."""
    focal_y_px: Annotated[float, Range(50, 20_000, "px")] | None = None
    """Focal length along v (px), 50-20,000, where pixels are not square; null = the same."""

    def __post_init__(self) -> None:
        if self.width * self.height > _MOST_PIXELS:
            raise ValueError(f"width x height must be at most {_MOST_PIXELS:,} px, found {self.width} x {self.height}")
        if self.distortion is not None and self.fisheye is not None:
            raise ValueError("distortion and fisheye are two kinds of lens: give one of them")
        camera = self.make()
        camera.require_clear_lens()
        _require_sane_view(camera.pinhole if self.fisheye is None else camera)

    @classmethod
    def from_plain(cls, data: Any, where: str) -> "CameraConfig":
        """Read a preset's name or a mapping of settings.

        Raises:
            ConfigError: Unknown preset or setting.
        """
        name = data.get("preset") if isinstance(data, dict) else data
        if not isinstance(name, str):
            return from_mapping(cls, _with_focal(data, cls().width, where), where)
        if name not in CAMERA_PRESETS:
            hint, known = suggestion(name, CAMERA_PRESETS), ", ".join(sorted(CAMERA_PRESETS))
            raise ConfigError(f"{where}: {shown(name)} is no camera preset{hint}; known: {known}")
        preset = CAMERA_PRESETS[name]
        if not isinstance(data, dict):
            return preset
        own = _with_focal({key: value for key, value in data.items() if key != "preset"}, preset.width, where)
        return from_mapping(cls, preset.to_plain() | own, where)

    def to_plain(self) -> dict[str, Any]:
        """Return what ``from_plain`` reads back; the lens only where there is one."""
        plain = {item.name: to_mapping(getattr(self, item.name)) for item in fields(self)}
        lenses = ("distortion", "fisheye", "focal_y_px")
        return {name: value for name, value in plain.items() if name not in lenses or value is not None}

    @property
    def hfov_deg(self) -> float:
        """Angle between the left and the right border of a pinhole image of this focal length (deg)."""
        return float(np.degrees(2.0 * np.arctan(self.width / (2.0 * self.focal_px))))

    def make(self) -> PinholeCamera:
        """Return the camera."""
        centred = PinholeCamera.from_focal(self.width, self.height, self.focal_px)
        cx = centred.cx if self.cx is None else self.cx
        cy = centred.cy if self.cy is None else self.cy
        lens = self.fisheye or (None if self.distortion == Distortion() else self.distortion)
        focal_y_px = self.focal_px if self.focal_y_px is None else self.focal_y_px
        return PinholeCamera(self.width, self.height, self.focal_px, focal_y_px, cx, cy, lens)


def _with_focal(data: Any, width: int, where: str) -> Any:
    """Return settings with ``focal_px`` in place of ``hfov_deg``, the angle across the image: f = w / (2 tan(a / 2)).

    Raises:
        ConfigError: Both are given, or the angle is out of range.
    """
    if not isinstance(data, dict) or "hfov_deg" not in data:
        return data
    if "focal_px" in data:
        raise ConfigError(f"{where}: hfov_deg and focal_px say the same: give one of them")
    angle, across = data["hfov_deg"], data.get("width", width)
    if isinstance(angle, bool) or not isinstance(angle, (int, float)) or not _LEAST_HFOV <= angle <= _WIDEST_HFOV:
        raise ConfigError(f"{where}: hfov_deg must be {_LEAST_HFOV:g}-{_WIDEST_HFOV:g} degrees, found {shown(angle)}")
    if isinstance(across, bool) or not isinstance(across, int):
        raise ConfigError(f"{where}: width must be int, found {shown(across)}")
    focal = across / (2.0 * np.tan(np.radians(angle) / 2.0))
    return {key: value for key, value in data.items() if key != "hfov_deg"} | {"focal_px": float(focal)}


def _require_sane_view(camera: PinholeCamera) -> None:
    """Reject a camera that sees next to nothing, or more than a plane image can show.

    Raises:
        ValueError: Names its angles.
    """
    left, right, top, bottom = np.degrees(np.arctan(camera.tangent_bounds()))
    if max(right - left, bottom - top) < _LEAST_VIEW_DEG or max(-left, right, -top, bottom) > _WIDEST_DEG:
        raise ValueError(
            f"focal_px {camera.fx:g} shows {left:.1f} to {right:.1f} deg across, {top:.1f} to {bottom:.1f} deg down; "
            f"a view must span at least {_LEAST_VIEW_DEG:g} deg and end {_WIDEST_DEG:g} deg off the axis"
        )


# Depth cameras see as their depth image does: D400 series 87 deg across and Flexx2 56 deg (data sheets), Kinect v1
# 525 px (OpenNI's default), Azure Kinect 504 px at 640 x 576 and the industrial time-of-flight camera 463 px (as their
# depth presets). A name that is a depth preset, too, brings that depth with it.
# KITTI's rectified colour camera 2, whose images vary about 1242 x 375 and are often cut to 1224 x 370.
CAMERA_PRESETS = {
    "kitti": CameraConfig(1224, 370, 721.5377),
    # Its colour camera 2 before rectification: S_02, K_02 (with fx for fy) and D_02 of the calib_cam_to_cam.txt of
    # 2011_09_26.
    "kitti_raw": CameraConfig(
        1392,
        512,
        959.791,
        696.0217,
        224.1806,
        Distortion(k1=-0.3691481, k2=0.1968681, p1=0.001353473, p2=0.0005677587, k3=-0.06770705),
    ),
    # A mast camera that overlooks an aisle, 95 x 53 deg: its lens shows equal angles as equal lengths, r' = arctan r,
    # to 0.003 up to 55 deg off the axis (least squares), which is wider than a pinhole image would stand.
    "wide": CameraConfig(1280, 720, 770.0, distortion=Distortion(k1=-0.31, k2=0.115, k3=-0.0208)),
    # A driver-assistance camera, 109 x 64 deg: about stereographic, r' = 2 tan(theta / 2), to 0.017 up to 66 deg off
    # the axis (least squares).
    "ultra_wide": CameraConfig(1280, 720, 625.0, distortion=Distortion(k1=-0.2082, k2=0.0438, k3=-0.00384)),
    # A camera that sees all about its front, 130 x 73 deg: equal angles as equal lengths (equidistant), which is near
    # how lenses for surroundings are built; practical prior.
    "fisheye": CameraConfig(1280, 720, 564.0, fisheye=Fisheye()),
    "d435": CameraConfig(848, 480, 446.8),
    "d435_720p": CameraConfig(1280, 720, 674.4),
    "d455": CameraConfig(848, 480, 446.8),
    "d455_720p": CameraConfig(1280, 720, 674.4),
    "azure_kinect": CameraConfig(640, 576, 504.0),
    "kinect_v1": CameraConfig(640, 480, 525.0),
    "flexx2": CameraConfig(224, 172, 210.6),
    "tof_industrial": CameraConfig(640, 480, 462.6),
    # A camera that reads labels from afar, 45 x 26 deg, with the slight pincushion of long lenses; practical prior.
    "tele": CameraConfig(1280, 720, 1545.0, distortion=Distortion(k1=0.03)),
}


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
