"""The hour outside: how bright the yard, the sky and windows look by day, at dusk and at night.

Levels are photographic rules of thumb for the open air: a dark overcast day gives some 1,000 lx, civil dusk some 100, a
yard at night 5-20 lx from lamps of its own, under a sky that glows a little over a town.

Daylight falls in through rooflights and bands of windows: a pane glows as the sky behind it does, and sends that into
the hall. A few lights stand for all panes; they are marked as fill: no pane is so near to a camera that its own shadows
would be seen.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from warehouse_sim.catalog.materials import OUTDOOR, SKY_BANDS, materials
from warehouse_sim.color import LUMINANCE
from warehouse_sim.scene.lighting.config import Hour, Preset
from warehouse_sim.schema import Light, Material, ObjectInstance, SceneSpec

_SKY = f"{OUTDOOR}sky_"
_GLASS = f"{OUTDOOR}window"
_LAMP = f"{OUTDOOR}lamp"


@dataclass(frozen=True)
class _Outdoors:
    """How an hour differs from the day that materials are given for."""

    sky: float
    """Luminance of the sky over that by day."""
    ground: float
    """Luminance of all else over that by day."""
    horizon: tuple[float, float, float]
    """Factors of the sky's colour at the horizon."""
    zenith: tuple[float, float, float]
    """Factors of the sky's colour at the zenith."""
    lamp: float
    """Luminance of the yard's lamps (cd/m^2)."""


_HOURS: dict[Hour, _Outdoors] = {
    "day": _Outdoors(1.0, 1.0, (1.0, 1.0, 1.0), (1.0, 1.0, 1.0), 0.0),
    "dusk": _Outdoors(0.11, 0.07, (1.0, 0.62, 0.38), (0.62, 0.72, 1.0), 4000.0),
    "night": _Outdoors(0.001, 0.008, (1.0, 0.85, 0.7), (0.6, 0.7, 1.0), 4000.0),
}


def outdoors_at(hour: Hour, materials: Mapping[str, Material]) -> dict[str, Material]:
    """Return how those of ``materials`` look that lie outdoors."""
    return {name: _at(hour, item) for name, item in materials.items() if name.startswith(OUTDOOR)}


def _at(hour: Hour, item: Material) -> Material:
    look = _HOURS[hour]
    if item.name == _LAMP:
        return replace(item, emission=look.lamp)
    is_sky = item.name.startswith(_SKY)
    height = int(item.name.removeprefix(_SKY)) / (SKY_BANDS - 1) if is_sky else 0.5
    factor = look.sky if is_sky or item.name == _GLASS else look.ground
    if is_sky or item.name == _GLASS:
        red, green, blue = (
            channel * ((1 - height) * low + height * high)
            for channel, low, high in zip(item.base_color, look.horizon, look.zenith, strict=True)
        )
        item = replace(item, base_color=(red, green, blue))
    return replace(item, emission=item.emission * factor)


PANE = "outdoor_window"
"""The catalog's material of panes."""
_ROOFLIGHT, _WINDOWS = "rooflight_", "window_band_"
"""What the names of models with panes begin with."""
_MOST = 8
"""Lights that stand for all panes which look the same way."""
_BEFORE = 0.15
"""How far before its pane a light stands (m): clear of the bars between panes."""
_CLEAR = 0.85
"""Fraction of a strip or band that is pane and not bar, by the catalog's models."""


def pane_lights(scene: SceneSpec, preset: Preset) -> tuple[Light, ...]:
    """Return the lights of all panes at the preset's hour; none where there are no panes, or at night.

    A Lambertian pane of luminance L and area A has L A candela on its axis and fades with the cosine; the widest cone
    of a spot fades with its square and gives 2/3 of the flux, which is made up for.
    """
    if preset.hour == "night" or PANE not in scene.materials:
        return ()
    pane = outdoors_at(preset.hour, {PANE: materials()[PANE]})[PANE]
    tone = np.array(pane.base_color)
    luminance = pane.emission * float(tone @ LUMINANCE)
    red, green, blue = (tone / float(tone @ LUMINANCE)).tolist()
    lights = []
    for direction, panes in _by_direction(scene).items():
        groups = np.array_split(np.arange(len(panes)), min(_MOST, len(panes)))
        for group in groups:
            places = np.array([panes[k][0] for k in group])
            # Before a pane that there is: between two of them may be a girder, which would keep all light off.
            middle = places[np.linalg.norm(places - places.mean(axis=0), axis=1).argmin()]
            area = sum(panes[k][1] for k in group)
            lights.append(
                Light(
                    kind="spot",
                    position=middle + _BEFORE * np.array(direction),
                    direction=np.array(direction),
                    intensity=1.5 * luminance * area * _CLEAR,
                    color=(red, green, blue),
                    cone_inner=0.0,
                    cone_outer=np.pi / 2.0,
                    radius=0.8,
                    fill=True,
                )
            )
    return tuple(lights)


def _by_direction(scene: SceneSpec) -> dict[tuple[float, ...], list[tuple[np.ndarray, float]]]:
    """Return middle (m) and area (m^2) of each strip or band by the direction that it looks in, along the walls."""
    found: dict[tuple[float, ...], list[tuple[np.ndarray, float]]] = {}
    for item in scene.instances:
        if item.model.startswith((_ROOFLIGHT, _WINDOWS)):
            direction, area = _pane(item, scene)
            found.setdefault(direction, []).append((item.T_world_object[:3, 3], area))
    return {way: sorted(panes, key=lambda pane: (pane[0][1], pane[0][0])) for way, panes in found.items()}


def _pane(item: ObjectInstance, scene: SceneSpec) -> tuple[tuple[float, ...], float]:
    """Return where a strip or band looks, and its area: rooflights look down, windows along their -y."""
    length, width, height = scene.model_of(item).size
    if item.model.startswith(_ROOFLIGHT):
        return (0.0, 0.0, -1.0), length * width
    return tuple(np.round(-item.T_world_object[:3, 1], 6).tolist()), length * height
