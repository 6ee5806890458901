"""Hide a target as far as wanted: slide an occluder sideways on the floor, or turn the camera till its border cuts."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from jaxtyping import Float

from warehouse_sim.generation.occlusion.occluded_scene import BEYOND, OccludedScene, fraction_behind, ground_line
from warehouse_sim.generation.occlusion.occluder import Occluder
from warehouse_sim.generation.occlusion.sight import Sight
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.schema import Viewpoint

CLEARANCE = 0.06
"""Least distance from an occluder to everything else (m)."""
_NEAREST, _FARTHEST = 0.9, 0.2
"""Least distance along the floor from it to the camera and from its middle to the target's (m)."""
_GUESSES, _DEPTHS = 30, 4
"""Depths drawn between the two, and how many of those that fit are tried."""
_STEPS = 12
_ASKEW = np.deg2rad(6.0)
"""Standard deviation of the heading of loads and trucks against the aisle (rad)."""


@dataclass(frozen=True, eq=False)
class Track:
    """The line on the floor along which an occluder is slid."""

    foot: Float[np.ndarray, " 3"]
    """Where it is in the line of sight (m)."""
    aside: Float[np.ndarray, " 3"]
    """Unit direction out of it."""
    yaw: float
    """Heading of the occluder (rad)."""

    def pose(self, offset: float) -> Transform:
        """Return T_world_occluder at an offset (m)."""
        return make_transform(rotation_z(self.yaw), self.foot + offset * self.aside)

    def fraction_at(self, sight: Sight, occluder: Occluder, offset: float) -> float:
        """Return the visible fraction with the occluder at an offset (m)."""
        return fraction_behind(sight, occluder, self.pose(offset))


def needed_height(sight: Sight, top: float) -> float:
    """Return how high (m) something on the floor must at least be to reach the line from the eye to a height ``top``.

    The line is lowest at one of its ends; very near either end nothing can stand.
    """
    return float(line_height(sight, top, np.array([0.3, 0.9])).min())


def line_height(sight: Sight, top: float, part: Float[np.ndarray, "..."]) -> Float[np.ndarray, "..."]:
    """Return the height (m) at each ``fraction`` of the way from the eye to a point at height ``top`` (m)."""
    return sight.eye[2] + part * (top - sight.eye[2])


def find_standing_pose(
    occluded: OccludedScene, sight: Sight, occluder: Occluder, wanted: float, tolerance: float, rng: np.random.Generator
) -> Transform | None:
    """Return where ``occluder`` stands free and leaves the ``wanted`` fraction within ``tolerance``, or None."""
    target = occluded.instance_of[sight.target]
    model = occluded.scene.model_of(target)
    centre, size = target.T_world_object[:3, 3], model.size
    way, length = ground_line(sight, centre)
    across = np.array([-way[1], way[0]])
    for distance in _distances(occluded, sight, occluder, float(centre[2] - size[2] / 2), way, length, rng):
        part = distance / length
        yaw, foot = _heading(occluder, rng), sight.eye[:2] + distance * way
        span = occluder.radius + part * float(np.linalg.norm(size[:2])) / 2 + 0.05
        for side in rng.permutation([-1.0, 1.0]):
            track = Track(np.array([*foot, 0.0]), np.array([*(side * across), 0.0]), yaw)
            offset = slide(partial(track.fraction_at, sight, occluder), span, wanted, tolerance)
            if offset is None:
                break
            T_world_occluder = track.pose(offset)
            if occluded.takes(occluder.envelope.placed(T_world_occluder), CLEARANCE):
                return T_world_occluder
    return None


def _distances(
    occluded: OccludedScene,
    sight: Sight,
    occluder: Occluder,
    height: float,
    way: Float[np.ndarray, " 2"],
    length: float,
    rng: np.random.Generator,
) -> Float[np.ndarray, " k"]:
    """Draw distances (m) from the eye where the occluder is in the aisle and higher than the line to ``height`` (m)."""
    half = float(occluder.envelope.size[:2].min()) / 2
    sampled = rng.uniform(_NEAREST + half, max(length - _FARTHEST, _NEAREST + half), _GUESSES)
    feet = sight.eye[:2] + sampled[:, None] * way
    fits = np.array([occluded.area.contains(foot, half - BEYOND) for foot in feet])
    fits &= line_height(sight, height, sampled / length) < occluder.height
    return sampled[fits & (sampled < length - _FARTHEST)][:_DEPTHS]


def slide(fraction_at: Callable[[float], float], span: float, wanted: float, tolerance: float) -> float | None:
    """Return an offset in 0..``span`` at which the fraction is ``wanted`` within ``tolerance``, found by bisection.

    The fraction must not exceed ``wanted`` at 0 and not be below it at ``span``, as for a thing that is slid out of the
    line of sight; any continuous course between has such an offset.

    Returns:
        The offset, or None when the fraction jumps over ``wanted`` or one of the ends is on the wrong side of it.
    """
    low, high = 0.0, span
    start = fraction_at(low)
    if abs(start - wanted) <= tolerance:
        return low
    if start > wanted or fraction_at(high) < wanted - tolerance:
        return None
    for _ in range(_STEPS):
        middle = (low + high) / 2
        fraction = fraction_at(middle)
        if abs(fraction - wanted) <= tolerance:
            return middle
        low, high = (middle, high) if fraction < wanted else (low, middle)
    return None


def _heading(occluder: Occluder, rng: np.random.Generator) -> float:
    """Draw a heading (rad): loads and trucks stand along the aisle or across it, small things any way."""
    if occluder.radius < 0.5:
        return float(rng.uniform(-np.pi, np.pi))
    return float(rng.integers(4) * np.pi / 2 + rng.normal(0.0, _ASKEW))


_TURN_REACH = np.deg2rad(75.0)
"""Most a camera is turned (rad)."""


def turn_to_truncate(
    occluded: OccludedScene, viewpoint: Viewpoint, target: int, wanted: float, tolerance: float, rays: int, side: float
) -> Viewpoint | None:
    """Return the viewpoint turned to ``side`` (1 = left) so that the ``wanted`` fraction is in sight, or None.

    The vehicle turns with its camera, about the optical centre.
    """

    def fraction_at(offset: float) -> float:
        turned = _turned(viewpoint, side * (_TURN_REACH - offset))
        sight = occluded.look(target, turned.T_world_camera, rays)
        return sight.fraction if sight is not None else 0.0

    offset = slide(fraction_at, _TURN_REACH, wanted, tolerance)
    return None if offset is None else _turned(viewpoint, side * (_TURN_REACH - offset))


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
