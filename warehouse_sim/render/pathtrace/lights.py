"""Lights and the sky as the path tracer samples them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from warehouse_sim.color import LUMINANCE
from warehouse_sim.render.light_selection import GROUND
from warehouse_sim.schema import Light
from warehouse_sim.schema.intensity import ANGLES, PLANES

_FLOOR = 0.02  # of a light's chance to be rendered: where its centre gives nothing, its rim may


@dataclass(frozen=True, eq=False)
class LightSample:
    """A point on a light as surfaces see it."""

    point: Any
    """World position (m)."""
    direction: Any
    """Unit vector from the surface to it."""
    irradiance: Any
    """Light (lx) that a surface facing it receives, over the probability of having drawn it."""
    casts_shadow: Any


class LightSampler:
    """All lights of a scene; spots are disks, point lights are balls, of their ``radius``.

    Each point of one shines with its fraction of the intensity, so that far away illuminance is intensity / distance^2.
    Between its two cone angles a spot fades as in glTF's KHR_lights_punctual: saturate(cos * scale + offset)^2; one
    with a distribution shines as that says, looked up bilinearly.
    """

    def __init__(self, lights: Sequence[Light]) -> None:
        given = {id(light.distribution): light.distribution for light in lights}
        tables = [item for item in given.values() if item is not None]
        self._tables = mi.Float(np.concatenate([item.fraction.ravel() for item in tables])) if tables else None
        first = {id(item): number * PLANES * ANGLES for number, item in enumerate(tables)}
        self._lights = [
            _SampledLight(light, first.get(id(light.distribution), -1), self._tables)
            for light in lights
            if light.intensity > 0.0
        ]

    def __len__(self) -> int:
        return len(self._lights)

    def sample(self, surface: Any, choice: Any, place: Any) -> LightSample:
        """Draw one light in proportion to what it would give without shadows, and a point on it.

        Args:
            surface: ``mi.SurfaceInteraction3f`` to be lit.
            choice: Uniform number that draws the light.
            place: Two uniform numbers that draw the point.
        """
        normal = dr.mulsign(surface.n, dr.dot(surface.n, surface.to_world(surface.wi)))
        weights = [light.importance(surface.p, normal) for light in self._lights]
        total = sum(weights[1:], weights[0])
        left = choice * total
        # The first light stands for all that rounding could leave undrawn.
        sampled = self._lights[0].state()
        weight = weights[0]
        passed = weights[0]
        for light, own in zip(self._lights[1:], weights[1:], strict=True):
            here = left >= passed
            sampled = {key: dr.select(here, value, sampled[key]) for key, value in light.state().items()}
            weight = dr.select(here, own, weight)
            passed += own
        return _point_on(sampled, surface.p, place, total / weight, self._tables)


class _SampledLight:
    """One light with its numbers as kernel arguments, so that the next scene's lights need no new kernel."""

    def __init__(self, light: Light, first: int, tables: Any) -> None:
        self._tables = tables
        inner, outer = np.cos(light.cone_inner), np.cos(light.cone_outer)
        is_spot = light.kind == "spot"
        scale = 1.0 / max(inner - outer, 1e-3) if is_spot else 0.0
        axis = np.asarray(light.direction, float) if is_spot else np.array([0.0, 0.0, -1.0])
        self._state: dict[str, Any] = {
            "position": mi.Point3f(np.asarray(light.position, float).tolist()),
            "axis": mi.Vector3f((axis / np.linalg.norm(axis)).tolist()),
            "intensity": mi.Color3f((light.intensity * np.array(light.color)).tolist()),
            "scale": mi.Float(float(scale)),
            "offset": mi.Float(float(-outer * scale) if is_spot else 1.0),
            "radius": mi.Float(light.radius),
            "ball": mi.Bool(not is_spot),
            "casts_shadow": mi.Bool(light.casts_shadow),
        }
        if tables is not None:
            self._state |= {"along": mi.Vector3f(list(light.along)), "first": mi.Int32(first)}
        self._power = mi.Float(light.intensity * float(LUMINANCE @ light.color))
        dr.make_opaque(self._state, self._power)

    def state(self) -> dict[str, Any]:
        return self._state

    def importance(self, point: Any, normal: Any) -> Any:
        """Return the illuminance (lx) from the light's centre, at least a small fraction of what it could be."""
        away = self._state["position"] - point
        squared = dr.maximum(dr.squared_norm(away), 1e-6)
        direction = away * dr.rsqrt(squared)
        facing = dr.maximum(dr.dot(normal, direction), _FLOOR)
        return self._power * facing * dr.maximum(_fraction(self._state, direction, self._tables), _FLOOR) / squared


def _point_on(light: dict[str, Any], point: Any, place: Any, weight: Any, tables: Any) -> LightSample:
    """Return a uniform point of the disk: across the axis of a spot, across the line of sight of a ball."""
    towards = dr.normalize(point - light["position"])
    frame = mi.Frame3f(dr.select(light["ball"], towards, light["axis"]))
    disk = mi.warp.square_to_uniform_disk_concentric(place) * light["radius"]
    source = light["position"] + frame.s * disk.x + frame.t * disk.y
    away = source - point
    squared = dr.maximum(dr.squared_norm(away), 1e-6)
    direction = away * dr.rsqrt(squared)
    fraction = _fraction(light, direction, tables)
    return LightSample(source, direction, light["intensity"] * (fraction * weight / squared), light["casts_shadow"])


def _fraction(light: dict[str, Any], direction: Any, tables: Any) -> Any:
    """Return the intensity over the greatest of a light that lies in ``direction``."""
    cone = _cone(light, direction)
    if tables is None:
        return cone
    side = dr.cross(light["along"], light["axis"])
    angle = dr.acos(dr.clip(-dr.dot(direction, light["axis"]), -1.0, 1.0)) * ((ANGLES - 1) / np.pi)
    turned = dr.atan2(-dr.dot(direction, side), -dr.dot(direction, light["along"])) * (PLANES / (2.0 * np.pi))
    row, column = dr.floor(turned), dr.minimum(dr.floor(angle), ANGLES - 2)
    down, right = turned - row, angle - column
    near = mi.Int32(row + PLANES) % PLANES
    far = (near + 1) % PLANES
    known = light["first"] >= 0

    def value(plane: Any, more: int) -> Any:
        index = dr.maximum(light["first"], 0) + plane * ANGLES + mi.Int32(column) + more
        return dr.gather(mi.Float, tables, mi.UInt32(index), known)

    mixed = dr.lerp(dr.lerp(value(near, 0), value(near, 1), right), dr.lerp(value(far, 0), value(far, 1), right), down)
    return dr.select(known, mixed, cone)


def _cone(light: dict[str, Any], direction: Any) -> Any:
    fraction = dr.clip(-dr.dot(direction, light["axis"]) * light["scale"] + light["offset"], 0.0, 1.0)
    return fraction * fraction


class Sky:
    """An even environment: its upper half gives an upward surface ``ambient`` (lx), its lower half is dimmer."""

    def __init__(self, ambient: float) -> None:
        self._radiance = mi.Float(ambient / np.pi)
        dr.make_opaque(self._radiance)

    def radiance(self, direction: Any) -> Any:
        """Return the luminance (cd/m^2) that comes from a world ``direction``."""
        return mi.Color3f(self._radiance * dr.select(direction.z >= 0.0, 1.0, GROUND))
