"""Short texts and frames as thin solids, for brands and stencils; x to the right, y up, z towards the reader."""

from functools import cache

from warehouse_sim.geometry.mesh import TriangleMesh, merge, unit_box
from warehouse_sim.geometry.solids import unit_tube

_ROWS, _PITCH = 7, 6
# Seven rows a letter, top first; the bits of a row from left (16) to right (1).
_LETTERS = {
    "-": (0, 0, 0, 31, 0, 0, 0),
    "0": (14, 17, 17, 17, 17, 17, 14),
    "1": (4, 12, 4, 4, 4, 4, 14),
    "3": (14, 17, 1, 6, 1, 17, 14),
    "4": (2, 6, 10, 18, 31, 2, 2),
    "5": (31, 16, 30, 1, 1, 17, 14),
    "7": (31, 1, 2, 4, 8, 8, 8),
    "9": (14, 17, 17, 15, 1, 17, 14),
    "A": (4, 10, 17, 17, 31, 17, 17),
    "C": (14, 17, 16, 16, 16, 17, 14),
    "D": (30, 17, 17, 17, 17, 17, 30),
    "E": (31, 16, 16, 30, 16, 16, 31),
    "H": (17, 17, 17, 31, 17, 17, 17),
    "I": (14, 4, 4, 4, 4, 4, 14),
    "L": (16, 16, 16, 16, 16, 16, 31),
    "N": (17, 25, 25, 21, 19, 19, 17),
    "O": (14, 17, 17, 17, 17, 17, 14),
    "P": (30, 17, 17, 30, 16, 16, 16),
    "S": (15, 16, 16, 14, 1, 1, 30),
    "T": (31, 4, 4, 4, 4, 4, 4),
    "U": (17, 17, 17, 17, 17, 17, 14),
    "W": (17, 17, 17, 21, 21, 27, 17),
    " ": (0, 0, 0, 0, 0, 0, 0),
}


@cache
def lettering(lines: tuple[str, ...]) -> TriangleMesh:
    """Return centred lines of text that fill the cube of edge 1 m.

    Raises:
        KeyError: A character has no shape.
    """
    bars = []
    for line, text in enumerate(lines):
        start = -len(text) * _PITCH / 2
        for place, letter in enumerate(text):
            for row, bits in enumerate(_LETTERS[letter]):
                y = -float(line * (_ROWS + 2) + row)
                bars += [_bar(start + place * _PITCH + left, y, length) for left, length in _runs(bits)]
    return _to_unit_cube(merge(bars))


@cache
def oval_brand(text: str) -> TriangleMesh:
    """Return ``text`` in an oval ring that fills the cube of edge 1 m, centred."""
    return merge([unit_tube(0.86, 32), _stretched(lettering((text,)), (0.66, 0.42, 1.0))])


@cache
def framed_brand(lines: tuple[str, ...]) -> TriangleMesh:
    """Return ``lines`` in a rectangular frame that fills the cube of edge 1 m, centred."""
    sides = [
        _stretched(unit_box(), size, centre)
        for size, centre in (
            ((1.0, 0.05, 1.0), (0.0, 0.475, 0.0)),
            ((1.0, 0.05, 1.0), (0.0, -0.475, 0.0)),
            ((0.03, 0.90, 1.0), (0.485, 0.0, 0.0)),
            ((0.03, 0.90, 1.0), (-0.485, 0.0, 0.0)),
        )
    ]
    return merge([*sides, _stretched(lettering(lines), (0.84, 0.74, 1.0))])


def _runs(bits: int) -> list[tuple[int, int]]:
    """Return (first column, length) of the unbroken runs of set bits."""
    columns = [column for column in range(5) if bits >> (4 - column) & 1]
    starts = [column for column in columns if column - 1 not in columns]
    return [(start, next(n for n in range(1, 6) if start + n not in columns)) for start in starts]


def _bar(left: float, y: float, length: int) -> TriangleMesh:
    return _stretched(unit_box(), (float(length), 1.0, 1.0), (left + length / 2, y, 0.0))


def _stretched(
    mesh: TriangleMesh, size: tuple[float, float, float], centre: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> TriangleMesh:
    return TriangleMesh(mesh.vertices * size + centre, mesh.faces)


def _to_unit_cube(mesh: TriangleMesh) -> TriangleMesh:
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    return TriangleMesh((mesh.vertices - (low + high) / 2) / (high - low), mesh.faces)
