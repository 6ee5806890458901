"""The hour outside: how bright the yard, the sky and windows look by day, at dusk and at night.

Levels are photographic rules of thumb for the open air: a dark overcast day gives some 1,000 lx, civil dusk some 100, a
yard at night 5-20 lx from lamps of its own, under a sky that glows a little over a town.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

from warehouse_sim.catalog.materials import OUTDOOR, SKY_BANDS
from warehouse_sim.schema import Material

Hour = Literal["day", "dusk", "night"]
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
