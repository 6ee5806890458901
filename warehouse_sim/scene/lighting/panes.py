"""Daylight that falls in through rooflights and bands of windows: a few lights that stand for all panes of a hall.

A pane glows as the sky behind it does, and sends that into the hall. The lights are marked as fill: no pane is so near
to a camera that its own shadows would be seen.
"""

import numpy as np

from warehouse_sim.catalog.materials import materials
from warehouse_sim.color import LUMINANCE
from warehouse_sim.scene.lighting.daylight import outdoors_at
from warehouse_sim.scene.lighting.presets import Preset
from warehouse_sim.schema import Light, ObjectInstance, SceneSpec

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
