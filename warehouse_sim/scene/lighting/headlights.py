"""The work lights of a vehicle: two floodlights on its overhead guard.

Two lights of 1,500 lm and 6000 K at 2.1 m, 0.9 m apart, with a beam of 50 degrees, pitched 10 degrees down: usual
values of LED work lights for trucks, estimated and not from a standard.
"""

import numpy as np

from warehouse_sim.color import balanced_rgb
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.scene.lighting.photometry import cone_of_beam, flux_per_candela
from warehouse_sim.schema import Light, Viewpoint

FLUX = 1500.0
"""Luminous flux of one light (lm)."""
HEIGHT = 2.1
"""Of the lights above the floor (m)."""
_APART = 0.9
_BEAM_DEG = 50.0
_PITCH = np.deg2rad(-10.0)
_KELVIN = 6000.0
_RADIUS = 0.04


def work_lights(viewpoint: Viewpoint, white_balance: float) -> tuple[Light, ...]:
    """Return the two lights of the vehicle of a viewpoint, in the world.

    A camera that nothing carries is lit from above itself, as if it were carried.

    Args:
        viewpoint: Where the vehicle stands.
        white_balance: Colour temperature that the camera takes for white (K).
    """
    T_world_floor = _stand(viewpoint)
    forward, left = T_world_floor[:3, 0], T_world_floor[:3, 1]
    inner, outer = cone_of_beam(_BEAM_DEG)
    return tuple(
        Light(
            kind="spot",
            position=T_world_floor[:3, 3] + HEIGHT * T_world_floor[:3, 2] + side * _APART / 2 * left,
            direction=np.cos(_PITCH) * forward + np.sin(_PITCH) * T_world_floor[:3, 2],
            intensity=FLUX / flux_per_candela(inner, outer),
            color=balanced_rgb(_KELVIN, white_balance),
            cone_inner=inner,
            cone_outer=outer,
            radius=_RADIUS,
        )
        for side in (-1.0, 1.0)
    )


def _stand(viewpoint: Viewpoint) -> Transform:
    """Return the frame on the floor, x forward and z up, of the vehicle or under the camera."""
    if viewpoint.T_world_vehicle is not None:
        return viewpoint.T_world_vehicle
    T = viewpoint.T_world_camera
    yaw = np.arctan2(T[1, 2], T[0, 2])
    frame = np.eye(4)
    frame[:3, 0], frame[:3, 1] = [np.cos(yaw), np.sin(yaw), 0.0], [-np.sin(yaw), np.cos(yaw), 0.0]
    frame[:2, 3] = T[:2, 3]
    return frame
