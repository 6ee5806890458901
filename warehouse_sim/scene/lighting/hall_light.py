"""The light of a hall beside its aisle: rows of luminaires under the roof, as many lights that no camera stands near.

A row has no switch of its own for each of its luminaires: a few lights along it stand for all, as strong as the floor
under them is wide. They are marked as fill, so that renderers may gather them with the indirect light.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from warehouse_sim.scene.lighting.photometry import cone_of_beam, flux_per_candela
from warehouse_sim.schema import Light, SceneSpec

ROW = "light_line"
"""How the catalog's rows of luminaires are called, and what their names begin with."""
_MOST = 24
"""Lights that stand for all rows of a hall."""
_LEAST_PITCH = 6.0
"""Least distance between two of them along a row (m)."""
_BEAM = 120.0
"""Full angle of half intensity of a row (deg): a Lambertian one."""
_UTILISED = 0.6
"""Share of the flux of luminaires that reaches the floor of a hall with goods in it (utilance; EN 12464-1 leaves it to
the planner, tables of makers give 0.5-0.8)."""
_RADIUS = 0.3
"""Radius of the disk that stands for some metres of row (m)."""


def fill_lights(scene: SceneSpec, lux: float, colors: Sequence[tuple[float, float, float]]) -> tuple[Light, ...]:
    """Return the lights of the rows of a scene.

    Args:
        scene: Its instances count.
        lux: Mean illuminance (lx) that they are to give the floor under them.
        colors: Linear RGB of unit luminance-like scale, of one row after the other; repeated.
    """
    rows = [item for item in scene.instances if item.model.startswith(ROW)]
    if not rows or lux <= 0.0:
        return ()
    lengths = [float(scene.model_of(item).size[0]) for item in rows]
    pitch = max(_LEAST_PITCH, sum(lengths) / max(_MOST - len(rows) / 2, 1))
    places = [
        (item.T_world_object[:3, 3] + item.T_world_object[:3, 0] * along, colors[number % len(colors)])
        for number, (item, length) in enumerate(zip(rows, lengths, strict=True))
        for along in _along(length, pitch)
    ]
    area = pitch * _spacing([item.T_world_object[:3, 3] for item in rows])
    inner, outer = cone_of_beam(_BEAM)
    intensity = lux * area / _UTILISED / flux_per_candela(inner, outer)
    below = np.array([0.0, 0.0, -0.1])
    return tuple(
        Light(
            kind="spot",
            position=place + below,
            direction=np.array([0.0, 0.0, -1.0]),
            intensity=intensity,
            color=color,
            cone_inner=inner,
            cone_outer=outer,
            radius=_RADIUS,
            fill=True,
        )
        for place, color in places
    )


def _along(length: float, pitch: float) -> Float[np.ndarray, " n"]:
    """Return places along a row (m), from its middle, ``pitch`` m apart or less."""
    count = max(int(np.ceil(length / pitch)), 1)
    return (np.arange(count) - (count - 1) / 2) * length / count


def _spacing(places: Sequence[Float[np.ndarray, " 3"]]) -> float:
    """Return the distance (m) between neighbouring rows, the median of all; 6 m where there is one row only."""
    across = np.unique(np.round([place[1] for place in places], 2))
    return float(np.median(np.diff(across))) if len(across) > 1 else 6.0
