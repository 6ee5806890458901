"""The perforated upright: one watertight mesh a height, so that every upright of a rack is the same instance.

Section as cold-formed by most European makers: a flat front with two columns of slots, straight sides, a waist, and
rear lips that the bracing is bolted to. Slot pitch 50 mm, sheet 2.5 mm.
"""

from functools import cache
from itertools import pairwise

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.mesh import TriangleMesh

UPRIGHT_WIDTH, UPRIGHT_DEPTH = 0.10, 0.08
"""Outer section of an upright along x and y (m)."""
HOLE_PITCH = 0.05
"""Distance from slot to slot along an upright (m); beams hang at multiples of it."""
HOLE_HEIGHT = 0.024
"""Height of a slot (m)."""
HOLE_OUTER, HOLE_TOP, HOLE_BOTTOM = 0.035, 0.019, 0.024
"""Distance (m) of a slot's outer edge, and of its slanted inner edge at top and bottom, from the upright's axis."""
SHEET = 0.0025
"""Thickness of the folded sheet (m)."""

_HALF_SECTION = ((0.05, 0.0), (0.05, 0.048), (0.03, 0.062), (0.03, 0.08), (0.014, 0.08))
"""Outer corners (x, y from the front) of the right half, from the front to the lip (m)."""
_FIRST, _LAST = 0.10, 0.05
"""Distance (m) of the lowest slot from the foot and of the highest one from the top, at least."""


def hole_heights(height: float) -> Float[np.ndarray, " n"]:
    """Return the heights (m) of the slots' centres above the foot of an upright of ``height`` (m)."""
    return np.arange(_FIRST, height - _LAST + 1e-9, HOLE_PITCH)


@cache
def upright_mesh(height: float) -> TriangleMesh:
    """Return an upright of ``height`` (m): front at -y, open to +y, centred on its bounding box."""
    outer, inner = _section()
    sheet = _Sheet(height)
    front, back = sheet.perforated(outer[4:6]), sheet.perforated(inner[4:6])
    sheet.walls(front, back)
    chains = []
    for line, web in ((outer, front), (inner, back)):
        left, right = web[0], web[-1]
        chains.append([sheet.line(p) for p in line[:4]] + [left, right] + [sheet.line(p) for p in line[6:]])
    sheet.folds(*chains)
    sheet.caps(chains, front, back)
    vertices = np.array(sheet.vertices) - [0.0, UPRIGHT_DEPTH / 2, height / 2]
    return TriangleMesh(vertices, np.array(sheet.faces, dtype=np.int32))


def _section() -> tuple[Float[np.ndarray, "10 2"], Float[np.ndarray, "10 2"]]:
    """Return the outer and the inner corners (m) of the folded sheet, from the left lip round the front to the right.

    The inner line is the outer one moved inwards by the sheet; at a fold both neighbours' offsets meet.
    """
    right = np.array(_HALF_SECTION)
    outer = np.concatenate([right[::-1] * [-1.0, 1.0], right])
    along = np.diff(outer, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    normal = np.column_stack([-along[:, 1], along[:, 0]])
    before, after = np.vstack([normal[:1], normal]), np.vstack([normal, normal[-1:]])
    inner = outer + SHEET * (before + after) / (1.0 + np.sum(before * after, axis=1, keepdims=True))
    return outer, inner


class _Sheet:
    """Vertices and faces while the upright is folded; faces are given counter-clockwise seen from outside."""

    def __init__(self, height: float) -> None:
        self.height = height
        self.vertices: list[tuple[float, float, float]] = []
        self.faces: list[tuple[int, int, int]] = []
        centres = hole_heights(height)
        edges = np.column_stack([centres - HOLE_HEIGHT / 2, centres + HOLE_HEIGHT / 2]).ravel()
        self._rows = np.concatenate([[0.0], edges, [height]])

    def line(self, point: Float[np.ndarray, " 2"]) -> list[int]:
        """Add the fold at ``point`` (x, y); return its lower and upper vertex."""
        return self._column([(point[0], 0.0), (point[0], self.height)], point[1])

    def perforated(self, ends: Float[np.ndarray, "2 2"]) -> list[list[int]]:
        """Add the front between ``ends`` with its slots; return its six columns of vertices from left to right."""
        y = ends[0, 1]
        # Row 0 and the last row are the sheet's ends; between them lower and upper edges of slots take turns.
        slant = np.where(np.arange(len(self._rows)) % 2 == 1, HOLE_BOTTOM, HOLE_TOP)
        at = [-HOLE_OUTER + 0.0 * slant, -slant, slant, HOLE_OUTER + 0.0 * slant]
        columns = [self._column(list(zip(x, self._rows, strict=True)), y) for x in at]
        return [self.line(ends[0]), *columns, self.line(ends[1])]

    def walls(self, front: list[list[int]], back: list[list[int]]) -> None:
        """Close both sides of the front and the four walls of every slot."""
        for web, flip in ((front, False), (back, True)):
            for number, (left, right) in enumerate(pairwise(web)):
                if number in (0, 4):
                    self._fan(left, right, flip)
                    continue
                for row in range(len(left) - 1):
                    if number == 2 or row % 2 == 0:
                        self.quad(left[row], right[row], right[row + 1], left[row + 1], flip)
        for first, second in ((1, 2), (3, 4)):
            for row in range(1, len(self._rows) - 1, 2):
                corners = [(first, row), (second, row), (second, row + 1), (first, row + 1)]
                for (c, r), (d, s) in zip(corners, corners[1:] + corners[:1], strict=True):
                    self.quad(front[c][r], front[d][s], back[d][s], back[c][r])

    def folds(self, outer: list[list[int]], inner: list[list[int]]) -> None:
        """Close the sheet's plain strips and its two long edges."""
        for number in (0, 1, 2, 3, 5, 6, 7, 8):
            for chain, flip in ((outer, False), (inner, True)):
                (a, d), (b, c) = chain[number], chain[number + 1]
                self.quad(a, b, c, d, flip)
        for number, flip in ((0, True), (9, False)):
            self.quad(outer[number][0], inner[number][0], inner[number][1], outer[number][1], flip)

    def caps(self, chains: list[list[list[int]]], front: list[list[int]], back: list[list[int]]) -> None:
        """Close foot and top."""
        for end, flip in ((0, True), (-1, False)):
            rows = []
            for chain, web in zip(chains, (front, back), strict=True):
                rows.append([c[end] for c in chain[:4]] + [c[end] for c in web] + [c[end] for c in chain[6:]])
            for (a, b), (d, c) in zip(pairwise(rows[0]), pairwise(rows[1]), strict=True):
                self.quad(a, b, c, d, flip)

    def quad(self, a: int, b: int, c: int, d: int, flip: bool = False) -> None:
        """Add two triangles; ``flip`` turns them over."""
        self.faces += [(a, c, b), (a, d, c)] if flip else [(a, b, c), (a, c, d)]

    def _fan(self, left: list[int], right: list[int], flip: bool) -> None:
        """Close the margin between the sheet's edge, two vertices, and a straight column of slot corners."""
        narrow, wide = (left, right) if len(left) == 2 else (right, left)
        mirrored = narrow is right
        for a, b in pairwise(wide):
            self.faces.append((narrow[0], a, b) if flip == mirrored else (narrow[0], b, a))
        last = (narrow[0], wide[-1], narrow[1])
        self.faces.append(last if flip == mirrored else last[::-1])

    def _column(self, places: list[tuple[float, float]], y: float) -> list[int]:
        first = len(self.vertices)
        self.vertices += [(float(x), float(y), float(z)) for x, z in places]
        return list(range(first, len(self.vertices)))
