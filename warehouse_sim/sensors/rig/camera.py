"""The camera of a rig: image size, focal length and lens."""

from dataclasses import dataclass, fields
from typing import Any

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion


@dataclass(frozen=True)
class CameraConfig:
    """A camera with square pixels; in YAML also the name of a preset, or ``preset`` with what differs from it."""

    width: int = 1224
    """Image width (px), >= 1."""
    height: int = 370
    """Image height (px), >= 1."""
    focal_px: float = 721.5377
    """Focal length (px), > 0."""
    cx: float | None = None
    """Principal point u (px), 0 at the centre of the first column; the image's centre when omitted."""
    cy: float | None = None
    """Principal point v (px), 0 at the centre of the first row; the image's centre when omitted."""
    distortion: Distortion | None = None
    """Brown-Conrady k1, k2, p1, p2, k3 of the lens as OpenCV has them; null = the image is rectified."""

    def __post_init__(self) -> None:
        self.make().require_clear_lens()  # refuses sizes and focal lengths that make no camera, and lenses that fold

    @classmethod
    def from_plain(cls, data: Any, where: str) -> "CameraConfig":
        """Read a preset's name or a mapping of settings.

        Raises:
            ConfigError: Unknown preset or setting.
        """
        name = data.get("preset") if isinstance(data, dict) else data
        if not isinstance(name, str):
            return from_mapping(cls, data, where)
        if name not in CAMERA_PRESETS:
            raise ConfigError(f"{where}: {name!r} is no camera preset; known: {', '.join(sorted(CAMERA_PRESETS))}")
        if not isinstance(data, dict):
            return CAMERA_PRESETS[name]
        own = {key: value for key, value in data.items() if key != "preset"}
        return from_mapping(cls, CAMERA_PRESETS[name].to_plain() | own, where)

    def to_plain(self) -> dict[str, Any]:
        """Return what ``from_plain`` reads back; the lens only where there is one."""
        plain = {item.name: to_mapping(getattr(self, item.name)) for item in fields(self)}
        return {name: value for name, value in plain.items() if name != "distortion" or value is not None}

    def make(self) -> PinholeCamera:
        """Return the camera."""
        centred = PinholeCamera.from_focal(self.width, self.height, self.focal_px)
        cx = centred.cx if self.cx is None else self.cx
        cy = centred.cy if self.cy is None else self.cy
        lens = None if self.distortion == Distortion() else self.distortion
        return PinholeCamera(self.width, self.height, self.focal_px, self.focal_px, cx, cy, lens)


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
    # to 0.003 up to 55 deg off the axis (least squares), which is wider than a pinhole picture would stand.
    "wide": CameraConfig(1280, 720, 770.0, distortion=Distortion(k1=-0.31, k2=0.115, k3=-0.0208)),
}
