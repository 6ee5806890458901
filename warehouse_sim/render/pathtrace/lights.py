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

_FLOOR = 0.02  # of a light's chance to be drawn: where its centre gives nothing, its rim may


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

    Each point of one shines with its share of the intensity, so that far away illuminance is intensity / distance^2.
    Between its two cone angles a spot fades as in glTF's KHR_lights_punctual: saturate(cos * scale + offset)^2.
    """

    def __init__(self, lights: Sequence[Light]) -> None:
        self._lights = [_SampledLight(light) for light in lights if light.intensity > 0.0]

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
        drawn = self._lights[0].state()
        weight = weights[0]
        passed = weights[0]
        for light, own in zip(self._lights[1:], weights[1:], strict=True):
            here = left >= passed
            drawn = {key: dr.select(here, value, drawn[key]) for key, value in light.state().items()}
            weight = dr.select(here, own, weight)
            passed += own
        return _point_on(drawn, surface.p, place, total / weight)


class _SampledLight:
    """One light with its numbers as kernel arguments, so that the next scene's lights need no new kernel."""

    def __init__(self, light: Light) -> None:
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
        self._power = mi.Float(light.intensity * float(LUMINANCE @ light.color))
        dr.make_opaque(self._state, self._power)

    def state(self) -> dict[str, Any]:
        return self._state

    def importance(self, point: Any, normal: Any) -> Any:
        """Return the illuminance (lx) from the light's centre, at least a small share of what it could be."""
        away = self._state["position"] - point
        squared = dr.maximum(dr.squared_norm(away), 1e-6)
        direction = away * dr.rsqrt(squared)
        facing = dr.maximum(dr.dot(normal, direction), _FLOOR)
        return self._power * facing * dr.maximum(_cone(self._state, direction), _FLOOR) / squared


def _point_on(light: dict[str, Any], point: Any, place: Any, weight: Any) -> LightSample:
    """Return a uniform point of the disk: across the axis of a spot, across the line of sight of a ball."""
    towards = dr.normalize(point - light["position"])
    frame = mi.Frame3f(dr.select(light["ball"], towards, light["axis"]))
    disk = mi.warp.square_to_uniform_disk_concentric(place) * light["radius"]
    source = light["position"] + frame.s * disk.x + frame.t * disk.y
    away = source - point
    squared = dr.maximum(dr.squared_norm(away), 1e-6)
    direction = away * dr.rsqrt(squared)
    return LightSample(
        source, direction, light["intensity"] * (_cone(light, direction) * weight / squared), light["casts_shadow"]
    )


def _cone(light: dict[str, Any], direction: Any) -> Any:
    share = dr.clip(-dr.dot(direction, light["axis"]) * light["scale"] + light["offset"], 0.0, 1.0)
    return share * share


class Sky:
    """An even environment: its upper half gives an upward surface ``ambient`` (lx), its lower half is dimmer."""

    def __init__(self, ambient: float) -> None:
        self._radiance = mi.Float(ambient / np.pi)
        dr.make_opaque(self._radiance)

    def radiance(self, direction: Any) -> Any:
        """Return the luminance (cd/m^2) that comes from a world ``direction``."""
        return mi.Color3f(self._radiance * dr.select(direction.z >= 0.0, 1.0, GROUND))
