"""The light of a hall beside its aisle: rows of luminaires under the roof, as many lights that no camera stands near.

A few lights along a row stand for its luminaires, as strong as the floor under them is wide. They shine as those over
the aisle do: in the preset's pattern, with its beam, tilt and failures, so that a kind of light is the same all over
the hall. They are marked as fill, so that renderers may gather them with the indirect light.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from warehouse_sim.scene.lighting.config import Preset
from warehouse_sim.scene.lighting.photometry import spot
from warehouse_sim.schema import Light, ObjectInstance, SceneSpec

ROW = "light_line"
"""How the catalog's rows of luminaires are called, and what their names begin with."""
_MOST = 24
"""Lights that stand for all rows of a hall."""
_LEAST_PITCH = 6.0
"""Least distance between two of them along a row (m)."""
_WIDE, _LAMBERTIAN = 100.0, 120.0
"""Full angle of half intensity (deg) of luminaires from which on a row of them has a Lambertian beam, as trunking."""
_UTILISED = 0.6
"""Fraction of the flux of luminaires that reaches the floor of a hall with goods in it (utilance; EN 12464-1 leaves it
to the planner, tables of makers give 0.5-0.8)."""
_WIDER = 2.0
"""Radius of the disk that stands for some metres of row, over that of one luminaire's source."""
_FLICKER = 0.25
"""Fraction of its flux that a luminaire that is about to fail gives."""


def fill_lights(
    scene: SceneSpec, lux: float, colors: Sequence[tuple[float, float, float]], preset: Preset, rng: np.random.Generator
) -> tuple[Light, ...]:
    """Return the lights of the rows of a scene that are on.

    Args:
        scene: Its instances count.
        lux: Mean illuminance (lx) that they are to give the floor under them, whatever fraction of them is on.
        colors: Linear RGB of unit luminance-like scale, of one row after the other; repeated.
        preset: Which of them are on, and how they shine.
        rng: Source of what fails.
    """
    rows = _rows_from_aisle(scene)
    if not rows or lux <= 0.0:
        return ()
    lengths = [float(scene.model_of(item).size[0]) for item in rows]
    lit = np.count_nonzero(preset.pattern) / len(preset.pattern)
    pitch = max(_LEAST_PITCH, sum(lengths) * lit**2 / max(_MOST - len(rows) / 2, 1))
    area = pitch * _spacing([item.T_world_object[:3, 3] for item in rows])
    of_rows = _fractions(len(rows), preset, rng)
    lights: list[Light] = []
    for number, (item, length) in enumerate(zip(rows, lengths, strict=True)):
        places = _along(length, pitch)
        for along, fraction in zip(places, _fractions(len(places), preset, rng), strict=True):
            flux = lux * area / _UTILISED * fraction * of_rows[number]
            if flux > 0.0:
                place = item.T_world_object[:3, 3] + item.T_world_object[:3, 0] * along
                way = (-1.0) ** len(lights)
                lights.append(_spot(place, item.T_world_object[:3, 0], flux, colors[number % len(colors)], preset, way))
    return tuple(lights)


def _rows_from_aisle(scene: SceneSpec) -> list[ObjectInstance]:
    """Return the rows of light, the nearest to the aisle first."""
    middle = 0.0 if scene.aisle is None else (scene.aisle[2] + scene.aisle[3]) / 2
    rows = [item for item in scene.instances if item.model.startswith(ROW)]
    return sorted(rows, key=lambda item: abs(float(item.T_world_object[1, 3]) - middle))


def _fractions(count: int, preset: Preset, rng: np.random.Generator) -> list[float]:
    """Return the fraction of its flux that each of ``count`` rows, or luminaires of a row, gives."""
    return failing(
        [preset.pattern[number % len(preset.pattern)] for number in range(count)], preset.failed_fraction, rng
    )


def failing(fractions: list[float], failed_fraction: float, rng: np.random.Generator) -> list[float]:
    """Return the fraction of its flux that each luminaire gives when some fail: one flickers, one at least is whole."""
    count = len(fractions)
    if failed_fraction == 0.0:
        return fractions
    dark = min(max(round(failed_fraction * count), 1), max(count - 2, 0))
    state = np.ones(count)
    state[:dark], state[dark : dark + 1] = 0.0, _FLICKER
    return (rng.permutation(state) * fractions).tolist()


def _spot(
    place: Float[np.ndarray, " 3"],
    length: Float[np.ndarray, " 3"],
    flux: float,
    color: tuple[float, float, float],
    preset: Preset,
    way: float,
) -> Light:
    """Return one light of a row, leaning as those over the aisle: to one end at ``way`` 1, to the other at -1."""
    beam = preset.distribution or (preset.beam_deg if preset.beam_deg < _WIDE else _LAMBERTIAN)
    tilt = np.deg2rad(preset.tilt_deg) * way
    return spot(
        beam,
        place + np.array([0.0, 0.0, -0.1]),
        np.array([np.sin(tilt), 0.0, -np.cos(tilt)]),
        length,
        flux,
        color=color,
        radius=preset.source_radius * _WIDER,
        fill=True,
    )


def _along(length: float, pitch: float) -> Float[np.ndarray, " n"]:
    """Return places along a row (m), from its middle, ``pitch`` m apart or less."""
    count = max(int(np.ceil(length / pitch)), 1)
    return (np.arange(count) - (count - 1) / 2) * length / count


def _spacing(places: Sequence[Float[np.ndarray, " 3"]]) -> float:
    """Return the distance (m) between neighbouring rows, the median of all; 6 m where there is one row only."""
    across = np.unique(np.round([place[1] for place in places], 2))
    return float(np.median(np.diff(across))) if len(across) > 1 else 6.0
