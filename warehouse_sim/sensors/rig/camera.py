"""The camera of a rig: image size and focal length."""

from dataclasses import dataclass
from typing import Any

from warehouse_sim.config import from_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.geometry.camera import PinholeCamera


@dataclass(frozen=True)
class CameraConfig:
    """A pinhole camera with square pixels; in YAML also the name of a preset, such as ``kitti``."""

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

    def __post_init__(self) -> None:
        self.make()  # refuses sizes and focal lengths that make no camera

    @classmethod
    def from_plain(cls, data: Any, where: str) -> "CameraConfig":
        """Read a preset's name or a mapping of settings.

        Raises:
            ConfigError: Unknown preset or setting.
        """
        if not isinstance(data, str):
            return from_mapping(cls, data, where)
        if data not in CAMERA_PRESETS:
            raise ConfigError(f"{where}: {data!r} is no camera preset; known: {', '.join(sorted(CAMERA_PRESETS))}")
        return CAMERA_PRESETS[data]

    def make(self) -> PinholeCamera:
        """Return the camera."""
        centred = PinholeCamera.from_focal(self.width, self.height, self.focal_px)
        cx = centred.cx if self.cx is None else self.cx
        cy = centred.cy if self.cy is None else self.cy
        return PinholeCamera(self.width, self.height, self.focal_px, self.focal_px, cx, cy)


# KITTI's rectified colour camera 2, whose images vary about 1242 x 375 and are often cut to 1224 x 370.
CAMERA_PRESETS = {"kitti": CameraConfig(1224, 370, 721.5377)}
