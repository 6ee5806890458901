"""A camera by preset, by numbers, or from a calibration file."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from warehouse_sim.api.arguments import checked
from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.sensors.rig import CAMERA_PRESETS, RigConfig, camera_settings, read_camera_file


class Camera:
    """An RGB-D camera: a preset, its own numbers, or a preset with some numbers replaced.

    Example:
        >>> ws.Camera("kitti")
        <Camera kitti: 1224 x 370 px, focal length 721.538 px>
        >>> ws.Camera(width=640, height=480, focal_px=500, depth="ideal").K.tolist()
        [[500.0, 0.0, 319.5], [0.0, 500.0, 239.5], [0.0, 0.0, 1.0]]

    Args:
        preset: Name of a camera, such as ``"d435"`` or ``"d435_720p"``; ``warehouse-sim list`` shows all.
        width: Image width (px).
        height: Image height (px).
        focal_px: Focal length (px).
        hfov_deg: Horizontal field of view (deg), instead of ``focal_px``.
        focal_y_px: Focal length along v (px) where pixels are not square.
        cx: Optical axis u (px), 0 at the centre of the first column; by default the image's middle.
        cy: Optical axis v (px).
        distortion: k1, k2, p1, p2, k3 of the lens as in OpenCV, by name.
        fisheye: k1 to k4 of a fisheye as in OpenCV, by name, instead of ``distortion``.
        depth: Whose depth errors it has: a depth camera such as ``"d455"``, or ``"ideal"`` for none; by default the
            preset's, or errors that grow with the square of the distance.

    Raises:
        UnknownNameError: There is no such preset.
        ConfigError: A number is out of range, or they describe no camera.
    """

    @checked
    def __init__(
        self,
        preset: str | None = None,
        *,
        width: int | None = None,
        height: int | None = None,
        focal_px: float | None = None,
        hfov_deg: float | None = None,
        focal_y_px: float | None = None,
        cx: float | None = None,
        cy: float | None = None,
        distortion: Mapping[str, float] | None = None,
        fisheye: Mapping[str, float] | None = None,
        depth: str | None = None,
    ) -> None:
        given = dict(
            width=width, height=height, focal_px=focal_px, hfov_deg=hfov_deg, focal_y_px=focal_y_px, cx=cx, cy=cy,
            distortion=distortion, fisheye=fisheye,
        )  # fmt: skip
        own = {key: _plain(value) for key, value in given.items() if value is not None}
        self._take(preset, own, depth, "ws.Camera")

    @classmethod
    @checked
    def from_file(cls, path: str | Path, depth: str | None = None) -> "Camera":
        """Read a calibration: ROS ``camera_info``, OpenCV's YAML or JSON, or BOP's ``camera.json``, lens included.

        Example:
            >>> ws.Camera.from_file("out/bop/camera.json").width == ws.Dataset("out")[0].camera.width
            True

        Args:
            path: The file.
            depth: Whose depth errors it has, as in ``ws.Camera``.

        Raises:
            ConfigError: The file holds no camera, or a lens that the camera model cannot hold.
        """
        camera = cls.__new__(cls)
        camera._take(None, read_camera_file(Path(path)), depth, str(path))
        return camera

    def __repr__(self) -> str:
        camera = self.model
        lens = "" if camera.distortion is None else f", {type(camera.distortion).__name__.lower()}"
        return (
            f"<Camera {self.name or 'own'}: {camera.width} x {camera.height} px, focal length {camera.fx:g} px{lens}>"
        )

    @property
    def model(self) -> PinholeCamera:
        """Its intrinsics: ``K``, ``width``, ``height``, ``fx``, ``fy``, ``cx``, ``cy``, ``distortion``, ``project``."""
        return self.rig.make_camera()

    @property
    def width(self) -> int:
        """Image width (px)."""
        return self.model.width

    @property
    def height(self) -> int:
        """Image height (px)."""
        return self.model.height

    @property
    def K(self) -> Float[np.ndarray, "3 3"]:
        """The 3 x 3 intrinsic matrix."""
        return self.model.K

    @property
    def settings(self) -> dict[str, Any]:
        """What a recipe's ``sensors`` says of it: ``camera`` and ``rgbd``."""
        plain = to_mapping(self.rig)
        return {key: plain[key] for key in ("camera", "rgbd")}

    def _take(self, preset: str | None, own: Mapping[str, Any], depth: str | None, where: str) -> None:
        sensors = camera_settings(preset, own, depth)
        self.name = preset or ""
        """Name of the preset; empty for a camera of its own numbers."""
        self.rig = from_mapping(RigConfig, {**sensors, "lidar": None, "imu": None}, where)
        """The sensors that it stands for."""


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    return {str(key): _plain(item) for key, item in value.items()} if isinstance(value, Mapping) else value


PRESET_NAMES = tuple(sorted(CAMERA_PRESETS))
"""Names that ``ws.Camera`` takes."""
