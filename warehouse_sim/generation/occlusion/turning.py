"""Turn a camera about the vertical until the border of the image cuts the target as far as asked."""

from dataclasses import replace

import numpy as np

from warehouse_sim.generation.occlusion.occluded_scene import OccludedScene
from warehouse_sim.generation.occlusion.standing import slide
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.schema import Viewpoint

_FARTHEST = np.deg2rad(75.0)
"""Most a camera is turned (rad)."""


def turn_to_truncate(
    occluded: OccludedScene, viewpoint: Viewpoint, target: int, wanted: float, tolerance: float, rays: int, side: float
) -> Viewpoint | None:
    """Return the viewpoint turned to ``side`` (1 = left) so that the ``wanted`` fraction is in sight, or None.

    The vehicle turns with its camera, about the optical centre.
    """

    def fraction_at(offset: float) -> float:
        turned = _turned(viewpoint, side * (_FARTHEST - offset))
        sight = occluded.look(target, turned.T_world_camera, rays)
        return sight.fraction if sight is not None else 0.0

    offset = slide(fraction_at, _FARTHEST, wanted, tolerance)
    return None if offset is None else _turned(viewpoint, side * (_FARTHEST - offset))


def _turned(viewpoint: Viewpoint, angle: float) -> Viewpoint:
    """Return the viewpoint turned by ``angle`` (rad) about the vertical through its optical centre."""
    eye = viewpoint.T_world_camera[:3, 3]
    T: Transform = make_transform(rotation_z(angle), eye - rotation_z(angle) @ eye)
    vehicle = viewpoint.T_world_vehicle
    x, y, z = (float(value) for value in rotation_z(angle) @ np.array(viewpoint.velocity))
    return replace(
        viewpoint,
        T_world_camera=T @ viewpoint.T_world_camera,
        T_world_vehicle=None if vehicle is None else T @ vehicle,
        velocity=(x, y, z),
    )
