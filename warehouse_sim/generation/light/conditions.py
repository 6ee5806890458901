"""What is stored of the light with an observation: on the floor, at the camera and on each target."""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Int32

from warehouse_sim.generation.light.meter import LightMeter, facing, rays_through
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.scene.lighting.exposure import ev_of_exposure
from warehouse_sim.schema import Conditions, Viewpoint

_TARGET_POINTS = 12
"""Places on a target at which its illuminance is measured."""
_TARGET_RAYS = (4,)
_STRIDE = 3
"""Pixels from one to the next among which those of large targets are chosen."""


def measure_conditions(meter: LightMeter, viewpoint: Viewpoint) -> Conditions:
    """Return what is stored of the light with an observation."""
    seen = meter.scene.seen_from(viewpoint)
    return Conditions(lighting=seen.lighting, floor_lux=meter.floor_lux, exposure_ev=ev_of_exposure(seen.exposure))


def target_illuminance(
    meter: LightMeter,
    viewpoint: Viewpoint,
    camera: PinholeCamera,
    instance_mask: Int32[np.ndarray, "h w"],
    targets: Sequence[int],
) -> Mapping[int, float]:
    """Return the mean illuminance (lx) of the visible surface of each target that is visible.

    Args:
        meter: The scene's.
        viewpoint: From where it is seen; its vehicle's lights count.
        camera: With what.
        instance_mask: What it sees, as rendered.
        targets: Instance ids.
    """
    pixels = [_spread(instance_mask, target) for target in targets]
    rows = np.concatenate([np.zeros((0, 2), int), *pixels])
    owners = np.repeat(np.asarray(targets, int), [len(item) for item in pixels])
    origin, directions = rays_through(viewpoint, camera, rows[:, 1], rows[:, 0])
    hits = meter.caster.cast(np.tile(origin, (len(directions), 1)), directions)
    # At an edge the ray through a pixel's centre may just miss what was rendered there.
    met = hits.instance_ids == owners
    directions, owners = directions[met], owners[met]
    points = origin + hits.distance[met, None] * directions
    normals = facing(hits.normals[met], directions)
    values = meter.illuminance(points, normals, (*meter.scene.lights, *viewpoint.lights), _TARGET_RAYS)
    return {int(target): float(values[owners == target].mean()) for target in np.unique(owners)}


def _spread(instance_mask: Int32[np.ndarray, "h w"], target: int) -> Int32[np.ndarray, "k 2"]:
    """Return rows and columns of at most ``_TARGET_POINTS`` pixels spread evenly over those that show ``target``."""
    found = np.argwhere(instance_mask[::_STRIDE, ::_STRIDE] == target) * _STRIDE
    if len(found) < _TARGET_POINTS:
        found = np.argwhere(instance_mask == target)
    steps = np.linspace(0, len(found) - 1, min(_TARGET_POINTS, len(found))).round().astype(int)
    return found[steps]
