"""A light meter for scenes: illuminance of any surface, with exact shadows and what other surfaces return.

It exposes viewpoints, and says what is stored of the light with an observation.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int, Int32

from warehouse_sim.color import LUMINANCE
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render.light_selection import GROUND
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.lighting.exposure import ExposureConfig, ev_of_exposure, exposure_of_ev
from warehouse_sim.scene.lighting.photometry import floor_points, light_illuminance
from warehouse_sim.schema import Conditions, Light, SceneSpec, Viewpoint

_HEADROOM = 2.5
"""Floor counts as free when nothing is lower above it (m)."""
_LIFT = 1e-3
"""How far rays start before a surface (m)."""
_GATHER = (24, 4, 1)
"""Rays from a point of the floor that gather what other surfaces return, and from the end of each of them."""
_METER_RAYS = (1,)
"""Rays that do so for a point that a camera's meter sees."""
_NEAR_LIGHT = 1.0
"""Nearest (m) to a light that a surface which returns some is taken to be: few rays find the bright spot beside one."""
_SATURATED = 50.0
"""Image value at the scene's exposure, of which 4 is about white, beyond which a meter sees no brighter source."""
_MOST_RETURNED = 0.8
"""Largest fraction of light that surfaces are taken to return on average, for the sum over all bounces."""

Points = Float[np.ndarray, "n 3"]
Values = Float[np.ndarray, " n"]


class LightMeter:
    """Measures one scene.

    Args:
        scene: Settled and lit.
        caster: Rays in the same geometry; it may have been made for a paired variant in another light.
    """

    def __init__(self, scene: SceneSpec, caster: RayCaster) -> None:
        self.scene, self.caster = scene, caster
        # One more row answers for rays that meet nothing, whose material is -1.
        met = [scene.materials[name] for name in caster.materials]
        luminance = np.array([item.base_color for item in met]).reshape(-1, 3) @ LUMINANCE
        metal, emission = np.array([(item.metallic, item.emission) for item in met]).reshape(-1, 2).T
        self._albedo = np.append(luminance * (1.0 - metal), 0.0)
        emission = np.minimum(emission * scene.exposure, _SATURATED)
        self._emitted = np.append(luminance * emission / scene.exposure, 0.0)

    @cached_property
    def floor_lux(self) -> float:
        """Mean illuminance of the free floor of the aisle (lx), without what vehicles carry."""
        points, up = self._free_floor
        return float(self.illuminance(points, up, self.scene.lights, _GATHER).mean())

    def illuminance(self, points: Points, normals: Points, lights: Sequence[Light], rays: Sequence[int]) -> Values:
        """Return the illuminance (lx) of surfaces: from lights, the even light and other surfaces.

        Args:
            points: Places on them in the world (m).
            normals: Unit normals there.
            lights: Those that are on.
            rays: How many rays gather the indirect light of a point, bounce after bounce.
        """
        return self.direct(points, normals, lights) + self.gathered(points, normals, rays)

    def direct(self, points: Points, normals: Points, lights: Sequence[Light], nearest: float = 0.01) -> Values:
        """Return the illuminance (lx) straight from ``lights``, with shadows as of points of light.

        What is nearer to a light than ``nearest`` (m) counts as that far.
        """
        total = np.zeros(len(points))
        for light in lights:
            values = light_illuminance(light, points, normals, nearest)
            lit = np.flatnonzero(values)
            if light.casts_shadow and len(lit):
                starts = points[lit] + _LIFT * normals[lit]
                lit = lit[self.caster.arrives(starts, np.asarray(light.position, float))]
            total[lit] += values[lit]
        return total

    def gathered(self, points: Points, normals: Points, rays: Sequence[int]) -> Values:
        """Return the illuminance (lx) from the even environment and from surfaces that other light falls on.

        As many bounces are followed as ``rays`` has numbers. What comes after the last is summed as the series that it
        begins: each bounce returns the same fraction.
        """
        if len(points) == 0:
            return np.zeros(0)
        count = rays[0]
        directions = _over_normals(normals, _cosine_directions(count))
        starts = np.repeat(points + _LIFT * normals, count, axis=0)
        hits = self.caster.cast(starts, directions)
        found = hits.distance < np.inf
        albedo = self._albedo[hits.materials]
        returned = np.zeros(len(starts))
        places = starts[found] + hits.distance[found, None] * directions[found]
        faces = facing(hits.normals[found], directions[found])
        arriving = self.direct(places, faces, self.scene.lights, _NEAR_LIGHT)
        if len(rays) > 1:
            arriving += self.gathered(places, faces, rays[1:])
        returned[found] = albedo[found] * arriving
        if len(rays) == 1:
            returned /= 1.0 - min(float(albedo.sum()) / max(len(albedo), 1), _MOST_RETURNED)
        sky = np.where(directions[:, 2] > 0.0, 1.0, GROUND) * self.scene.ambient * ~found
        return (returned + sky).reshape(-1, count).mean(axis=1)

    def luminance(self, origin: Float[np.ndarray, " 3"], directions: Points, lights: Sequence[Light]) -> Values:
        """Return the luminance (cd/m^2) seen from ``origin`` (m) along ``directions``; surfaces are taken as matt."""
        hits = self.caster.cast(np.tile(origin, (len(directions), 1)), directions)
        found = np.flatnonzero(hits.distance < np.inf)
        albedo, emitted = self._albedo[hits.materials], self._emitted[hits.materials]
        seen = np.full(len(directions), GROUND * self.scene.ambient / np.pi)
        if len(found) == 0:
            return seen
        places = origin + hits.distance[found, None] * directions[found]
        faces = facing(hits.normals[found], directions[found])
        # So few rays say little of one point, and enough of them all: indirect light varies slowly.
        light = self.direct(places, faces, lights) + self.gathered(places, faces, _METER_RAYS).mean()
        seen[found] = albedo[found] * light / np.pi + emitted[found]
        return seen

    @cached_property
    def _free_floor(self) -> tuple[Points, Points]:
        """Points (m) of the aisle's floor that nothing stands on or hangs low over, and their normals."""
        points = floor_points(self.scene)
        up = np.tile([0.0, 0.0, 1.0], (len(points), 1))
        free = self.caster.cast(points, up).distance > _HEADROOM
        chosen = points[free] if free.any() else points
        return chosen, up[: len(chosen)]


def facing(normals: Float[np.ndarray, "n 3"], directions: Points) -> Points:
    """Return ``normals`` turned to where rays along ``directions`` come from."""
    behind = (normals * directions).sum(axis=1) > 0.0
    return np.where(behind[:, None], -normals, normals).astype(float)


def _cosine_directions(count: int) -> Points:
    """Return unit vectors about z whose density falls with the cosine: a spiral over the disk, lifted (Malley 1988)."""
    index = np.arange(count) + 0.5
    radius, angle = np.sqrt(index / count), index * np.pi * (1.0 + np.sqrt(5.0))
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1.0 - radius**2)], axis=1)


def _over_normals(normals: Points, directions: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, "m 3"]:
    """Return all ``directions`` about each normal, turned about it by an angle of its own; normal after normal."""
    across = np.where(np.abs(normals[:, 2:]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    u = np.cross(across, normals)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(normals, u)
    turn = 2.399963 * np.arange(len(normals))[:, None]  # golden angle (rad)
    x = np.cos(turn) * directions[:, 0] - np.sin(turn) * directions[:, 1]
    y = np.sin(turn) * directions[:, 0] + np.cos(turn) * directions[:, 1]
    turned = x[..., None] * u[:, None] + y[..., None] * v[:, None] + directions[:, 2][None, :, None] * normals[:, None]
    return turned.reshape(-1, 3)


_COLUMNS, _ROWS = 20, 12
_CENTRE = 0.6
"""Standard deviation of the meter's weight about the image's centre, in half image sizes."""


def metered_exposure(meter: LightMeter, viewpoint: Viewpoint, camera: PinholeCamera, config: ExposureConfig) -> float:
    """Return the exposure (linear image value of 1 cd/m^2) of a viewpoint, from rays on a grid over its image.

    Args:
        meter: The scene's.
        viewpoint: Where the camera stands; its vehicle's lights count.
        camera: What looks.
        config: How it is exposed.
    """
    x = (np.arange(_COLUMNS) + 0.5) / _COLUMNS
    y = (np.arange(_ROWS) + 0.5) / _ROWS
    u, v = (grid.ravel() for grid in np.meshgrid(x * camera.width - 0.5, y * camera.height - 0.5))
    origin, directions = rays_through(viewpoint, camera, u, v)
    luminance = meter.luminance(origin, directions, (*meter.scene.lights, *viewpoint.lights))
    off_x, off_y = 2.0 * (u + 0.5) / camera.width - 1.0, 2.0 * (v + 0.5) / camera.height - 1.0
    weights = np.exp(-(off_x**2 + off_y**2) / (2.0 * _CENTRE**2))
    return exposure_of_ev(config.ev_for(luminance, weights))


def following(views: Iterable[Viewpoint], lag: float) -> Iterator[Viewpoint]:
    """Yield viewpoints with the exposure of a camera that follows its meter late within each drive.

    The exposure value goes towards the metered one by ``1 - exp(-dt / lag)`` of the difference, as a discrete filter of
    first order; the first image of a drive is as it was metered.

    Args:
        views: With their metered exposures; those of a drive in order of time.
        lag: Time constant (s), > 0.
    """
    before: dict[int, tuple[float, float]] = {}
    for view in views:
        if view.sequence is None or view.exposure is None:
            yield view
            continue
        ev = ev_of_exposure(view.exposure)
        if view.sequence in before:
            time, last = before[view.sequence]
            ev = last + (ev - last) * -float(np.expm1(-(view.time - time) / lag))
        before[view.sequence] = view.time, ev
        yield replace(view, exposure=exposure_of_ev(ev))


def rays_through(
    viewpoint: Viewpoint, camera: PinholeCamera, u: Float[np.ndarray, " n"], v: Float[np.ndarray, " n"]
) -> tuple[Float[np.ndarray, " 3"], Float[np.ndarray, "n 3"]]:
    """Return the camera's place in the world (m), and the directions through pixels."""
    T = viewpoint.T_world_camera
    return T[:3, 3], camera.rays_at(u, v) @ T[:3, :3].T


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
    pixels = spread_pixels(instance_mask, targets)
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


def spread_pixels(instance_mask: Int32[np.ndarray, "h w"], targets: Sequence[int]) -> list[Int[np.ndarray, "k 2"]]:
    """Return rows and columns of at most ``_TARGET_POINTS`` pixels of each target, spread evenly over those it has."""
    found = [pixels * _STRIDE for pixels in _pixels_of(instance_mask[::_STRIDE, ::_STRIDE], targets)]
    few = [number for number, pixels in enumerate(found) if len(pixels) < _TARGET_POINTS]
    for number, pixels in zip(few, _pixels_of(instance_mask, [targets[number] for number in few]), strict=True):
        found[number] = pixels
    counts = [min(_TARGET_POINTS, len(pixels)) for pixels in found]
    steps = (np.linspace(0, len(pixels) - 1, count) for pixels, count in zip(found, counts, strict=True))
    return [pixels[step.round().astype(int)] for pixels, step in zip(found, steps, strict=True)]


def _pixels_of(ids: Int32[np.ndarray, "h w"], targets: Sequence[int]) -> list[Int[np.ndarray, "k 2"]]:
    """Return rows and columns of the pixels of each target, row by row; one look at the image for all of them."""
    wanted = np.zeros(max([int(ids.max()), *targets]) + 1, bool)
    wanted[list(targets)] = True
    pixels = np.argwhere(wanted[ids])
    owners = ids[pixels[:, 0], pixels[:, 1]]
    order = np.argsort(owners, kind="stable")
    first, last = (np.searchsorted(owners[order], targets, side) for side in ("left", "right"))
    return [pixels[order[a:b]] for a, b in zip(first, last, strict=True)]
