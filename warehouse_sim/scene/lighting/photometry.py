"""From lumen and beam angle to candela, and from candela to lux.

Spots fall off as in glTF's KHR_lights_punctual: with c the cosine of the angle to the axis and c_i, c_o those of the
inner and the outer half angle, I(c) = I_0 * saturate((c - c_o) / (c_i - c_o))^2.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from warehouse_sim.scene.draft import Area
from warehouse_sim.schema import IntensityDistribution, Light, SceneSpec

_ALONG, _ACROSS = 12, 6


def floor_points(scene: SceneSpec) -> Float[np.ndarray, "n 3"]:
    """Return a grid of points on the aisle's floor (m).

    Raises:
        ValueError: The scene does not say where its aisle is.
    """
    if scene.aisle is None:
        raise ValueError(f"scene {scene.scene_index} has no aisle whose light could be measured; set SceneSpec.aisle")
    area = Area(*scene.aisle)
    x = area.x_min + (np.arange(_ALONG) + 0.5) / _ALONG * (area.x_max - area.x_min)
    y = area.y_min + (np.arange(_ACROSS) + 0.5) / _ACROSS * (area.y_max - area.y_min)
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    return np.column_stack([grid, np.full(len(grid), 0.01)])


_WIDEST = np.deg2rad(85.0)
_OUTER = 1.6
"""Outer half angle of a spot's cone over its half-power angle."""


def cone_of_beam(beam_deg: float) -> tuple[float, float]:
    """Return the inner and outer half angles (rad) of the cone whose intensity is half at the edge of the beam.

    Args:
        beam_deg: Full angle between the directions of half intensity (deg), 10-150, as data sheets give it.
    """
    half = np.deg2rad(beam_deg) / 2.0
    outer = min(_OUTER * half, _WIDEST)
    # Half intensity is where the cosine is 1 / sqrt(2) of the way from outer to inner.
    inner_cosine = np.sqrt(2.0) * (np.cos(half) - np.cos(outer) * (1.0 - np.sqrt(0.5)))
    return float(np.arccos(min(inner_cosine, 1.0))), float(outer)


def flux_per_candela(cone_inner: float, cone_outer: float) -> float:
    """Return the luminous flux (lm) of a spot of 1 cd on its axis: 2 pi ((1 - c_i) + (c_i - c_o) / 3)."""
    inner, outer = np.cos(cone_inner), np.cos(cone_outer)
    return float(2.0 * np.pi * ((1.0 - inner) + (inner - outer) / 3.0))


def luminous_flux(light: Light) -> float:
    """Return the flux (lm) of a light."""
    if light.kind == "point":
        return 4.0 * np.pi * light.intensity
    if light.distribution is not None:
        return light.intensity * light.distribution.flux_per_candela
    return light.intensity * flux_per_candela(light.cone_inner, light.cone_outer)


def relative_intensity(
    light: Light, cosine: Float[np.ndarray, " n"], directions: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, " n"]:
    """Return the intensity of a light as a fraction of ``Light.intensity``.

    Args:
        light: The light.
        cosine: Of the angle between its axis and each of the directions.
        directions: Unit vectors away from it; only a light with a distribution requires more than the cosine.
    """
    if light.kind == "point":
        return np.ones_like(cosine)
    if light.distribution is not None:
        axis = np.asarray(light.direction, float)
        return light.distribution.at(directions, axis, np.asarray(light.along)).astype(cosine.dtype, copy=False)
    inner, outer = np.cos(light.cone_inner), np.cos(light.cone_outer)
    return np.clip((cosine - outer) / max(inner - outer, 1e-3), 0.0, 1.0) ** 2


def light_illuminance(
    light: Light, points: Float[np.ndarray, "n 3"], normals: Float[np.ndarray, "n 3"], nearest: float = 0.01
) -> Float[np.ndarray, " n"]:
    """Return the illuminance (lx) that a light gives without obstacles: I cos(incidence) / r^2.

    Args:
        light: The light.
        points: Places in the world (m).
        normals: Unit normals of the surfaces there.
        nearest: Distance (m) that what is nearer counts as having.
    """
    to_light = np.asarray(light.position, float) - points
    distance = np.maximum(np.linalg.norm(to_light, axis=1), 1e-6)
    towards = to_light / distance[:, None]
    incidence = np.maximum((towards * normals).sum(axis=1), 0.0)
    fraction = relative_intensity(light, -towards @ np.asarray(light.direction, float), -towards)
    return light.intensity * fraction * incidence / np.maximum(distance, nearest) ** 2


def unshadowed_illuminance(
    lights: Sequence[Light], points: Float[np.ndarray, "n 3"], normals: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, " n"]:
    """Return the illuminance (lx) that all lights give together, ignoring shadows."""
    return sum((light_illuminance(light, points, normals) for light in lights), np.zeros(len(points)))


_WIDEST_CONE = np.deg2rad(89.0)
"""Half angle of the widest cone that a distribution is taken to fill where only cones are known."""


def spot(
    beam: float | IntensityDistribution,
    position: Float[np.ndarray, " 3"],
    direction: Float[np.ndarray, " 3"],
    length: Float[np.ndarray, " 3"],
    flux: float,
    *,
    color: tuple[float, float, float],
    radius: float,
    fill: bool = False,
) -> Light:
    """Return how a luminaire shines: in a cone by a formula, or as its photometric file says.

    Args:
        beam: Full angle of half intensity (deg), or what the file says.
        position: World position (m).
        direction: Unit axis in the world.
        length: Unit vector along the luminaire's length, that a distribution turns with; not along the axis.
        flux: What it gives (lm).
        color: Linear RGB of unit luminance-like scale.
        radius: Of the disk that emits (m).
        fill: As of ``Light``.
    """
    if isinstance(beam, IntensityDistribution):
        inner, outer, per_candela = 0.0, min(beam.widest, float(_WIDEST_CONE)), beam.flux_per_candela
    else:
        inner, outer = cone_of_beam(beam)
        per_candela = flux_per_candela(inner, outer)
    light = Light(
        kind="spot",
        position=position,
        direction=direction,
        intensity=flux / per_candela,
        color=color,
        cone_inner=inner,
        cone_outer=outer,
        radius=radius,
        fill=fill,
    )
    if not isinstance(beam, IntensityDistribution):
        return light
    across = length - (length @ direction) * direction
    x, y, z = (across / np.linalg.norm(across)).tolist()
    return replace(light, distribution=beam, along=(x, y, z))


def as_cone(light: Light) -> Light:
    """Return a light for renderers that draw cones only: of the same flux and half angle, without a distribution."""
    if light.distribution is None:
        return light
    half = float(np.clip(np.degrees(2.0 * light.distribution.half_angle), 10.0, 150.0))
    inner, outer = cone_of_beam(half)
    intensity = light.intensity * light.distribution.flux_per_candela / flux_per_candela(inner, outer)
    return replace(light, intensity=intensity, cone_inner=inner, cone_outer=outer, distribution=None)
