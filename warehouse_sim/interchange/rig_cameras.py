"""The cameras of a rig at each viewpoint of a scene, for programs that keep cameras as objects of the scene."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from warehouse_sim.config import to_mapping
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.schema import SceneSpec, Viewpoint
from warehouse_sim.sensors.rig import RigConfig


@dataclass(frozen=True, eq=False)
class RigCamera:
    """One camera of the rig at one viewpoint."""

    name: str
    """ "camera_000", and "right_000" for the second camera of a stereo pair."""
    camera: PinholeCamera
    T_world_camera: Transform
    """OpenCV axes."""
    viewpoint: Viewpoint

    def to_plain(self) -> dict[str, Any]:
        """Return what formats with centred, lensless cameras cannot hold, as plain values: K, lens, what it is for."""
        lens = self.camera.distortion
        return {
            "width": self.camera.width,
            "height": self.camera.height,
            "K": self.camera.K.ravel().tolist(),
            "lens": None if lens is None else {"model": type(lens).__name__.lower(), **to_mapping(lens)},
            "viewpoint": self.viewpoint.kind,
            "target": self.viewpoint.target,
            "time": self.viewpoint.time,
        }


def rig_cameras(scene: SceneSpec, rig: RigConfig | None) -> list[RigCamera]:
    """Return the cameras of ``rig`` at the viewpoints of ``scene`` in their order; none without a rig."""
    if rig is None:
        return []
    camera, found = rig.make_camera(), []
    for number, viewpoint in enumerate(scene.viewpoints):
        found.append(RigCamera(f"camera_{number:03d}", camera, viewpoint.T_world_camera, viewpoint))
        if rig.right is not None:
            aside = make_transform(None, np.array([rig.right.baseline, 0.0, 0.0]))
            T_world_right = viewpoint.T_world_camera @ aside
            found.append(RigCamera(f"right_{number:03d}", camera, T_world_right, viewpoint))
    return found
