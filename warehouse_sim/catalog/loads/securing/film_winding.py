"""Stretch film as a machine winds it: a spiral of overlapping turns, more of them at foot and top, folds and a tail.

Film of 500 mm width rises by 300 mm a turn, so that 200 mm of each turn lie over the one before; three turns and more
hold foot and top. What has more layers is less clear: each number of layers has a material of its own, and none of them
lies over another, so that all renderers agree. Its folds, roped edges and loose end are narrow strips of denser film.
The film has no collision boxes and is transparent to true depth and instance masks, as its materials' opacity is below
1.
"""

import itertools
import zlib
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog.loads.securing import OBJ_ID
from warehouse_sim.catalog.loads.securing.film_skin import (
    COLUMNS,
    FilmSkin,
    Level,
    Sheet,
    band_faces,
    film_skin,
    laid_on,
)
from warehouse_sim.catalog.parts import mesh_part, model_of
from warehouse_sim.geometry.mesh import TriangleMesh, merge
from warehouse_sim.schema import ObjectModel

THIN, DOUBLE, DENSE = "stretch_film_thin", "stretch_film", "stretch_film_dense"
"""Materials of film in one pass of the machine, two of them, and many."""
_WIDTH, _RISE = 0.5, 0.3
"""Width of the film and how far it rises in a turn (m)."""
_FOOT, _HEAD = 0.26, 0.22
"""Heights of the dense bands at foot and top (m)."""
_ROW = 0.14
"""Greatest height of a facet (m)."""
_AWAY = 0.004
"""Distance of the film from the goods (m)."""
_PROUD = 0.0012
"""How far folds stand over the film (m)."""
_CLOSED_FRACTION = 0.3
"""Fraction of the loads whose top is covered, too."""
_OVER_TOP = 0.09
"""How far film reaches over the edge of an open top (m)."""
_SLIVER = 1e-8
"""Faces of this area (m^2) and less are left out."""
_NARROW = 1e-6
"""Strips up to this height (m) are none."""
_SIDE = COLUMNS // 4


def wound_film(levels: Sequence[Level], slack: float) -> tuple[ObjectModel, Float[np.ndarray, " 3"]]:
    """Return film around ``levels``, given from the ground up, and where its centre lies in their frame (m).

    Args:
        levels: Layers of goods that stand on each other.
        slack: How loose the film is, 0-1: its waves, and how far the edges of its turns sag.
    """
    key = np.concatenate([np.append(level.outline.ravel(), [level.low, level.high]) for level in levels])
    tag = zlib.crc32(np.round(np.append(key, slack), 6).tobytes())
    # What is alike has like film: nothing is sampled from the scene's streams.
    rng = np.random.default_rng(tag)
    skin = film_skin(levels, _AWAY, slack, rng)
    start = float(rng.uniform(-_RISE, 0.0))
    sheets = _turns(skin, start, slack)
    sheets[DENSE] += [*_folds(skin, rng), *_edges(skin, start, slack), _tail(skin, rng)]
    meshes = laid_on(skin, sheets)
    top = _top(skin, levels[-1].outline, closed=bool(rng.random() < _CLOSED_FRACTION))
    meshes[THIN] = merge([meshes[THIN], top])
    merged = {material: _without_slivers(mesh) for material, mesh in meshes.items() if len(mesh.faces)}
    points = np.concatenate([mesh.vertices for mesh in merged.values()])
    low, high = points.min(axis=0), points.max(axis=0)
    centre = (low + high) / 2
    model = model_of(
        f"wrap~{tag:08x}",
        "wrap",
        OBJ_ID,
        high - low,
        tuple(
            mesh_part(TriangleMesh(mesh.vertices - centre, mesh.faces), material) for material, mesh in merged.items()
        ),
        (),
        mass=0.25,
    )
    return model, centre


def _without_slivers(mesh: TriangleMesh) -> TriangleMesh:
    """Return the mesh without faces of no area and the vertices that only these have."""
    used, faces = np.unique(mesh.faces[mesh.face_areas() > _SLIVER], return_inverse=True)
    return TriangleMesh(mesh.vertices[used], faces.reshape(-1, 3).astype(np.int32))


def _turn_edges(skin: FilmSkin, start: float, slack: float) -> Float[np.ndarray, "edges columns"]:
    """Return the heights (m) of the edges of all turns at each column, its lower and its upper one by turns."""
    count = int(np.ceil((skin.high - skin.low) / _RISE)) + 3
    column = np.arange(COLUMNS + 1)
    lower = skin.low + start + _RISE * (np.arange(count)[:, None] - 1 + column / COLUMNS)
    lower = lower - 0.035 * slack * np.abs(np.sin(np.pi * column / _SIDE))
    return np.stack([lower, lower + _WIDTH - _RISE], axis=1).reshape(2 * count, -1)


def _turns(skin: FilmSkin, start: float, slack: float) -> dict[str, list[Sheet]]:
    """Return the film by material: two layers where turns overlap, one between, many at foot and top."""
    edges = _turn_edges(skin, start, slack)
    foot, head = _bands(skin)
    knots = np.unique(np.round([*skin.heights, foot, head], 4))
    rows = np.concatenate([
        np.linspace(low, high, int(np.ceil((high - low) / _ROW)), endpoint=False)
        for low, high in itertools.pairwise(knots)
    ])  # fmt: skip
    rows = np.append(rows, knots[-1])
    found: dict[str, list[Sheet]] = {THIN: [], DOUBLE: [], DENSE: []}
    for low, high in itertools.pairwise(rows):
        middle = (low + high) / 2
        if middle < foot or middle > head:
            found[DENSE].append(_strip(np.full(COLUMNS + 1, low), np.full(COLUMNS + 1, high)))
            continue
        lines = np.clip(edges, low, high)
        for number in np.flatnonzero(np.any(lines[1:] > lines[:-1] + _NARROW, axis=1)):
            found[THIN if number % 2 else DOUBLE].append(_strip(lines[number], lines[number + 1]))
    return found


def _bands(skin: FilmSkin) -> tuple[float, float]:
    """Return up to where the dense band at the foot reaches and from where the one at the top does (m)."""
    span = skin.high - skin.low
    return skin.low + min(_FOOT, 0.35 * span), skin.high - min(_HEAD, 0.3 * span)


def _strip(low: np.ndarray, high: np.ndarray) -> Sheet:
    """Return the film between two lines around the load, given by their heights (m) at each column."""
    column = np.arange(COLUMNS + 1, dtype=float)
    return Sheet(np.stack([column, column]), np.stack([low, high]), wide=high - low > _NARROW)


def _ribbon(skin: FilmSkin, column: np.ndarray, height: np.ndarray, width: np.ndarray) -> Sheet:
    """Return a strip of film of varying ``width`` (m), measured upwards, along a line on the skin."""
    lines = np.stack([height - width / 2, height + width / 2])
    return Sheet(np.stack([column, column]), np.clip(lines, skin.low, skin.high), _PROUD)


def _folds(skin: FilmSkin, rng: np.random.Generator) -> list[Sheet]:
    """Return folds that run slantwise over a side from a corner, where film is pulled down or up."""
    folds = []
    span = skin.high - skin.low
    for corner in np.flatnonzero(rng.random(4) < 0.9):
        for _ in range(int(rng.integers(2, 6))):
            reach, sign = rng.uniform(0.25, 0.95) * _SIDE, rng.choice([-1.0, 1.0])
            fraction = np.linspace(0.0, 1.0, 9)
            drop = rng.uniform(0.05, 0.4) * min(1.0, span) * rng.choice([-1.0, 1.0])
            height = skin.low + span * rng.uniform(0.08, 0.92) + drop * fraction + 0.012 * np.sin(7.0 * fraction)
            width = rng.uniform(0.004, 0.014) * (1.0 - 0.8 * fraction)
            column = (corner * _SIDE + sign * reach * fraction) % COLUMNS
            order = slice(None) if sign > 0 else slice(None, None, -1)
            folds.append(_ribbon(skin, column[order], height[order], width[order]))
    return folds


def _edges(skin: FilmSkin, start: float, slack: float) -> list[Sheet]:
    """Return the edges of the turns, a few millimetres that are curled or roped."""
    foot, head = _bands(skin)
    column = np.arange(COLUMNS + 1, dtype=float)
    found = []
    for line in _turn_edges(skin, start, slack):
        inside = (line > foot) & (line < head)
        if inside.any():
            width = np.where(inside, 0.0035 + 0.002 * np.sin(5.0 * column), 0.0)
            found.append(_ribbon(skin, column, np.clip(line, foot, head), width))
    for level, wide in ((skin.low + 0.008, 0.014), (foot, 0.005), (head, 0.005)):
        found.append(_ribbon(skin, column, np.full(COLUMNS + 1, level), np.full(COLUMNS + 1, wide)))
    return found


def _tail(skin: FilmSkin, rng: np.random.Generator) -> Sheet:
    """Return the end of the film, which hangs down roped from where it was torn off and tucked in."""
    span = skin.high - skin.low
    top = skin.low + span * rng.uniform(0.45, 0.85)
    drop = min(rng.uniform(0.15, 0.45), 0.9 * (top - skin.low))
    fraction = np.linspace(0.0, 1.0, 10)
    centre = _SIDE * rng.integers(4) + rng.uniform(1.5, _SIDE - 1.5) + 0.25 * np.sin(rng.uniform(3.0, 7.0) * fraction)
    half = rng.uniform(0.1, 0.3) * (1.0 - 0.75 * fraction + 0.12 * np.sin(9.0 * fraction))
    height = top - drop * fraction
    column = np.stack([(centre + side * half) % COLUMNS for side in (-1.0, 1.0)])
    return Sheet(column, np.stack([height, height]), 0.004)


def _top(skin: FilmSkin, outline: Float[np.ndarray, "n 2"], *, closed: bool) -> TriangleMesh:
    """Return what lies on the top: a sheet over all of it, or what reaches over its edge."""
    column = np.arange(COLUMNS + 1, dtype=float)
    edge = skin.points(column, np.full(COLUMNS + 1, skin.high))
    middle = outline.mean(axis=0)
    inwards = middle - edge[:, :2]
    far = np.linalg.norm(inwards, axis=1, keepdims=True)
    uneven = 1.0 + 0.35 * np.sin(0.9 * column)[:, None]
    reach = far if closed else np.minimum(_OVER_TOP * uneven, 0.5 * far)
    inner = np.column_stack([edge[:, :2] + inwards / far * reach, edge[:, 2] + 0.003])
    return TriangleMesh(np.concatenate([edge, inner]), band_faces(len(edge)))
