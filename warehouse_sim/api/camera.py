"""A camera by preset, by numbers or from a calibration file; and a rig: camera, LiDAR, what carries them, how high."""

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from jaxtyping import Float

from warehouse_sim.api.arguments import checked
from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import UnknownNameError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.ranges import Range
from warehouse_sim.scene.viewpoints.mountings import carried_by
from warehouse_sim.sensors.rig import RigConfig, camera_settings, read_camera_file, rig_names
from warehouse_sim.sensors.rig.shipped import rig_settings


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


class Rig:
    """A camera, a LiDAR if there is one, and what carries them.

    Example:
        >>> rig = ws.Rig(camera="kitti", lidar="os1_128", on="forklift", height=1.2)
        >>> recipe = ws.recipe("demo", sensors=rig)
        >>> recipe.settings["scene"]["viewpoints"]["height"]
        1.2

    Args:
        camera: Name of a camera, or a ``ws.Camera``; by default KITTI's.
        lidar: Name of a LiDAR, such as ``"os1_64"``; none by default.
        on: What carries it: ``"forklift"``, ``"amr"``, ``"post"``, ``"ceiling"``, ``"free"`` or another kind of
            viewpoints; by default what the recipe says.
        height: Of the camera above the floor (m), 0.1-20; by default what the recipe or the carrier says.
        rig: Name of a shipped rig, or path of a rig's YAML file, of which the others replace parts.

    Raises:
        UnknownNameError: There is no such camera, LiDAR, carrier or rig.
    """

    @checked
    def __init__(
        self,
        camera: str | Camera | None = None,
        lidar: str | None = None,
        on: str | None = None,
        height: Annotated[float, Range(0.1, 20, "m")] | None = None,
        *,
        rig: str | None = None,
    ) -> None:
        settings: dict[str, Any] = {"lidar": None, "imu": None} if rig is None else _shipped(rig)
        if camera is not None:
            settings |= (camera if isinstance(camera, Camera) else Camera(camera)).settings
        if lidar is not None:
            settings["lidar"] = lidar
        self.config = from_mapping(RigConfig, settings, "ws.Rig")
        """The sensors as the strict reader has them."""
        self._lidar = lidar
        kind = None if on is None else carried_by(on)
        self.viewpoints: dict[str, Any] = {} if kind is None else {"kind": kind}
        """What a recipe's ``scene.viewpoints`` says of it."""
        if height is not None:
            self.viewpoints["height"] = float(height)

    def __repr__(self) -> str:
        camera, lidar = self.config.make_camera(), self.config.lidar
        parts = [f"camera {camera.width} x {camera.height} px"]
        parts += [] if lidar is None else [f"LiDAR {self._lidar or lidar.model}"]
        parts += [f"{key} {value}" for key, value in self.viewpoints.items()]
        return f"<Rig {', '.join(parts)}>"

    @property
    def sensors(self) -> dict[str, Any]:
        """What a recipe's ``sensors`` says of it, in full."""
        return {item.name: to_mapping(getattr(self.config, item.name)) for item in fields(self.config)}


def _shipped(name: str) -> dict[str, Any]:
    if not name.endswith((".yaml", ".yml")) and name not in rig_names():
        raise UnknownNameError("rig", name, rig_names())
    return dict(rig_settings(name, "ws.Rig: rig"))
