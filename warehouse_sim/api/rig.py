"""A sensor rig in a few words: which camera, which LiDAR, what carries them, how high."""

from dataclasses import fields
from typing import Annotated, Any

from warehouse_sim.api.arguments import checked
from warehouse_sim.api.camera import Camera
from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import UnknownNameError
from warehouse_sim.ranges import Range
from warehouse_sim.scene.viewpoints.mountings import carried_by
from warehouse_sim.sensors.rig import RigConfig, rig_names
from warehouse_sim.sensors.rig.shipped import rig_settings


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
