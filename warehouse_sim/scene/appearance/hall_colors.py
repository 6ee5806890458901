"""Colours as a hall shows them: paint and board in use, racks in pairs that makers sell, one customer's prints.

Only what images show changes. Remission stays that of the surface as it was drawn, so that LiDARs and depth cameras
read the same: at 905 nm binders and fibres decide more than pigments, and dust less than at the lens.
"""

import colorsys
import re
import zlib
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from warehouse_sim.color import LUMINANCE, linear_from_srgb, srgb_from_linear
from warehouse_sim.scene.appearance.surfaces import (
    BLUE_5005,
    BLUE_5010,
    BLUE_5015,
    GREEN_6005,
    GREEN_6029,
    GREY_7016,
    GREY_7035,
    ORANGE_2003,
    ORANGE_2004,
    ORANGE_2008,
    PRINTS,
    RED_3000,
    WHITE_9002,
    YELLOW_1003,
)
from warehouse_sim.schema import Material, SceneSpec

_BRIGHT = ("hivis_", "sign_", "safety_", "skin_", "reflective", "outdoor_", "lamp_", "led_", "cone_", "location_label")
"""How materials are called that keep their colour: what must be seen, skin, light, and what is outside."""
_FIBRES = ("kraft", "tape", "sack_paper", "board_face", "pallet_wood", "pallet_block", "wood_")
_PALED, _FIBRES_PALED = 0.35, 0.22
"""Fraction of the way to its own grey that paint, ink and plastic have gone in use, and that board and wood have;
estimates: charts show new chips under even light, and no source measured racks."""
_GUARDS_PALED = 0.2
"""The same of guards, which are bought to be seen."""
_ORANGE = (ORANGE_2004, ORANGE_2008, ORANGE_2003)
_BLUE = (BLUE_5010, BLUE_5015, BLUE_5005)
RACK_PAIRS: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...] = (
    (_BLUE, (*_ORANGE, YELLOW_1003, GREY_7035)),
    ((GREY_7035, GREY_7016, WHITE_9002), (*_ORANGE, BLUE_5010, BLUE_5015, YELLOW_1003, GREY_7035, RED_3000)),
    ((GREEN_6005, GREEN_6029), (ORANGE_2004, YELLOW_1003, GREY_7035)),
    (_ORANGE, (BLUE_5010, GREY_7035)),
    ((YELLOW_1003, RED_3000), (GREY_7035, BLUE_5010)),
)
"""Colours of uprights, and those of the beams that go with them; galvanised steel goes with all."""
_SAME_HUE = 10.0 / 360.0
"""Difference of hues below which two paints are one colour; halls turn them by some degrees."""
_GREY = 0.4
"""Spread of a linear colour over its greatest channel up to which it is a grey, or white."""
_KRAFT_HUES = (14.0 / 360.0, 42.0 / 360.0)
_MOST_OF_KRAFT = 0.9
"""That spread, up to which what has a hue of kraft is kraft."""
_ON_WHITE = 0.7
"""Fraction of the customers whose full colours are prints on white board; an estimate."""
_INKS = 2
"""Inks of one customer beside black."""
Color = Float[np.ndarray, "3"]


def in_hall_colors(scene: SceneSpec, rng: np.random.Generator) -> SceneSpec:
    """Return ``scene`` with the colours of its materials as its hall shows them; objects of users keep theirs.

    Args:
        scene: Painted.
        rng: Stream that the beams' colour and the customer's are sampled from; always as many numbers.
    """
    beam, white = rng.random(2)
    weights = np.array([0.0 if _grey(_linear(finish.code)) else finish.weight for finish in PRINTS])
    chosen = rng.choice(len(PRINTS), _INKS, replace=False, p=weights / weights.sum())
    inks = [_linear(PRINTS[number].code) for number in chosen]
    beams = _beams_beside(scene.materials, float(beam))
    own = {item.name for model in scene.models.values() for item in model.materials}
    found = {
        name: replace(item, base_color=_rounded(_shown(item, inks, beams, white < _ON_WHITE)))
        for name, item in scene.materials.items()
        if name not in own
    }
    return replace(scene, materials=scene.materials | found)


def _shown(item: Material, inks: list[Color], beams: Color | None, on_white: bool) -> Color:
    """Return what a material looks like.

    Args:
        item: As it was painted.
        inks: The customer's.
        beams: Colour of all beams; None = as they are.
        on_white: Whether the customer's full colours are on white board, so that no carton has one all over.
    """
    name, color = item.name, np.array(item.base_color)
    if name.startswith(_BRIGHT) or item.emission > 0.0:
        return color
    if beams is not None and name.startswith("rack_orange") and item.metallic == 0.0:
        color = beams
    elif name.startswith(("kraft", "board_white")) and _colourful(color):
        color = np.array([0.70, 0.69, 0.65]) if on_white else inks[0]
    elif name.startswith("print_") and _colourful(color):
        color = inks[zlib.crc32(name.encode()) % _INKS]
    return paled(
        color, _FIBRES_PALED if name.startswith(_FIBRES) else _GUARDS_PALED if name.startswith("guard_") else _PALED
    )


def paled(color: Color, fraction: float) -> Color:
    """Return a linear colour a ``fraction`` of the way to the grey of its luminance."""
    return color + fraction * (float(LUMINANCE @ color) - color)


def _beams_beside(materials: dict[str, Material], place: float) -> Color | None:
    """Return the colour of beams that goes with the uprights, or None where they go together or are bare.

    Args:
        materials: The scene's.
        place: Which of the colours that go together, 0-1.
    """
    uprights, beams = (_last(materials, name) for name in ("rack_blue", "rack_orange"))
    if uprights is None or beams is None or uprights.metallic > 0.0:
        return None
    for codes, partners in RACK_PAIRS:
        if any(_alike(uprights, code) for code in codes):
            if any(_alike(beams, code) for code in partners):
                return None
            return _linear(partners[int(place * len(partners))])
    return None


def _last(materials: dict[str, Material], name: str) -> Material | None:
    """Return the material that things of the catalog's ``name`` are painted with: the last that is called after it."""
    found = [item for key, item in materials.items() if re.split("[ ~]", key)[0] == name]
    return found[-1] if found else None


def _alike(item: Material, code: str) -> bool:
    """Return whether a paint has the hue of a colour of the chart, or both are greys."""
    color, chart = np.array(item.base_color), _linear(code)
    if _grey(color) or _grey(chart):
        return _grey(color) and _grey(chart)
    away = abs(_hue(color) - _hue(chart))
    return min(away, 1.0 - away) < _SAME_HUE


def _colourful(color: Color) -> bool:
    """Return whether board or ink of this colour is none of kraft, white, grey or black."""
    low, high = _KRAFT_HUES
    return not _grey(color) and not (low < _hue(color) < high and _spread(color) < _MOST_OF_KRAFT)


def _grey(color: Color) -> bool:
    return _spread(color) < _GREY or float(color.max()) < 0.03


def _spread(color: Color) -> float:
    return float(np.ptp(color) / max(float(color.max()), 1e-4))


def _hue(color: Color) -> float:
    return colorsys.rgb_to_hsv(*map(float, srgb_from_linear(color)))[0]


def _linear(code: str) -> Color:
    return linear_from_srgb(np.array([int(code[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0)


def _rounded(color: Color) -> tuple[float, float, float]:
    red, green, blue = (round(float(channel), 4) for channel in color)
    return red, green, blue
