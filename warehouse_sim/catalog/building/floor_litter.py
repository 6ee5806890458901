"""What work leaves on the floor of an aisle: dust where no wheel runs, scraps of board and film, straps, splinters.

All of it is flat and a film, as tracks are: depth, instance ids and labels are those of the floor.
"""

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.mesh import TriangleMesh, merge
from warehouse_sim.geometry.solids import prism

THICK = 0.0002
"""Thickness of each piece (m)."""
_BESIDE = (0.26, 0.46)
"""Where most of it lies, on both sides: fraction of the aisle's width from its middle."""
_STRAYS = 0.35
"""Fraction of it that lies anywhere."""
_STRAP = 0.012
"""Width of a strap (m)."""
_SHAPES = {
    "floor_board": ((0.02, 0.09), 1.6),
    "floor_film": ((0.06, 0.22), 2.4),
    "floor_splinter": ((0.015, 0.06), 9.0),
}
"""Material -> radius of a piece (m), and how many times as long as wide it is at most."""
_EVERY = 1.2
"""Length of an aisle with one scrap of board at most (m); the other kinds are in proportion."""


def floor_litter(
    length: float, width: float, low: Float[np.ndarray, "2"], high: Float[np.ndarray, "2"], rng: np.random.Generator
) -> dict[str, TriangleMesh]:
    """Return the pieces by their material, in the frame of an aisle, x along it and z = 0 in the middle of each piece.

    Args:
        length: Of the aisle (m).
        width: Of it (m).
        low: Least x and y of any piece (m).
        high: Greatest x and y (m).
        rng: Stream to draw from.
    """
    count = max(int(length / _EVERY), 1)
    some = {"floor_board": count, "floor_film": count // 3, "floor_splinter": 3 * count}
    pieces = {"floor_dust": [band(line, float(rng.uniform(0.03, 0.11))) for line in _drifts(length, width, rng)]}
    for material, most in some.items():
        outlines = [_scrap(rng, *_SHAPES[material]) for _ in range(rng.integers(most // 2, most + 1))]
        pieces[material] = [_slab(_thrown(item, length, width, rng)) for item in outlines]
    curls = [_curl(rng) for _ in range(rng.integers(1, count // 3 + 2))]
    pieces["floor_strap"] = [band(_thrown(item, length, width, rng), _STRAP) for item in curls]
    found = {}
    for material, meshes in pieces.items():
        kept = [item for item in meshes if (item.vertices[:, :2] > low).all() and (item.vertices[:, :2] < high).all()]
        if kept:
            found[material] = merge(kept)
    return found


def _drifts(length: float, width: float, rng: np.random.Generator) -> list[Float[np.ndarray, "n 2"]]:
    """Return lines along both sides on which dust gathers, broken where somebody swept."""
    lines = []
    for side in (-1.0, 1.0):
        x = -length / 2 + rng.uniform(0.2, 1.5)
        while x < length / 2 - 0.6:
            end = min(x + rng.uniform(0.5, 3.0), length / 2 - 0.1)
            along = np.linspace(x, end, max(int((end - x) / 0.15), 4))
            sway = 0.02 * np.sin(along * rng.uniform(2.0, 6.0) + rng.uniform(0.0, 6.3))
            lines.append(np.column_stack([along, side * rng.uniform(0.36, 0.47) * width + sway]))
            x = end + rng.uniform(0.1, 2.5)
    return lines


def _curl(rng: np.random.Generator) -> Float[np.ndarray, "n 2"]:
    """Return the line of a strap that was cut and fell."""
    turn = np.cumsum(np.full(20, rng.uniform(-0.25, 0.25)) + rng.normal(0.0, 0.04, 20))
    return np.cumsum(rng.uniform(0.015, 0.05) * np.column_stack([np.cos(turn), np.sin(turn)]), axis=0)


def _scrap(rng: np.random.Generator, radius: tuple[float, float], stretch: float) -> Float[np.ndarray, "n 2"]:
    """Return the outline of a torn piece of a ``radius`` (m), up to ``stretch`` times as long as wide."""
    corners = int(rng.integers(4, 8))
    angle = 2 * np.pi * (np.arange(corners) + rng.uniform(0.0, 0.7, corners)) / corners
    reach = rng.uniform(*radius) * rng.uniform(0.6, 1.0, corners)
    return np.column_stack([np.cos(angle), np.sin(angle) / rng.uniform(0.6 * stretch, stretch)]) * reach[:, None]


def _slab(outline: Float[np.ndarray, "n 2"]) -> TriangleMesh:
    x, y = outline.T.tolist()
    return prism(tuple(zip(x, y, strict=True)), THICK)


def _thrown(
    outline: Float[np.ndarray, "n 2"], length: float, width: float, rng: np.random.Generator
) -> Float[np.ndarray, "n 2"]:
    """Return a piece turned any way, and lying where things gather."""
    turn, stray = rng.uniform(-np.pi, np.pi), rng.random() < _STRAYS
    y = rng.uniform(-0.4, 0.4) if stray else rng.choice([-1.0, 1.0]) * rng.uniform(*_BESIDE)
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    return (outline - outline.mean(axis=0)) @ rotation.T + [rng.uniform(-0.5, 0.5) * length, y * width]


def band(line: Float[np.ndarray, "n 2"], width: float, narrowed: float = 0.15) -> TriangleMesh:
    """Return the closed band of ``width`` m along a line; its ends are ``narrowed`` to that fraction."""
    along = np.gradient(line, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    fraction = np.ones(len(line))
    fraction[[0, -1]] = narrowed
    across = np.column_stack([-along[:, 1], along[:, 0]]) * (fraction * width / 2)[:, None]
    count, z = len(line), THICK / 2
    rings = [(line - across, -z), (line + across, -z), (line + across, z), (line - across, z)]
    vertices = np.concatenate([np.column_stack([points, np.full(count, level)]) for points, level in rings])
    a, b = np.arange(count - 1), np.arange(1, count)
    faces = []
    for side in range(4):
        low, high = side * count, (side + 1) % 4 * count
        faces += [np.column_stack([a + low, a + high, b + high]), np.column_stack([a + low, b + high, b + low])]
    last = count - 1
    ends = [(0, 2 * count, count), (0, 3 * count, 2 * count)]
    ends += [(last, last + count, last + 2 * count), (last, last + 2 * count, last + 3 * count)]
    return TriangleMesh(vertices, np.concatenate([*faces, np.array(ends)]).astype(np.int32))
