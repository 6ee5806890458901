"""What is printed on packages: words, barcodes, handling marks, as flat shapes that are put on the sides of a box.

Shapes are polygons in a side's own plane (m): x to the right and y up, seen from outside, the origin in the middle. The
handling marks follow the symbols of ISO 780: this way up, fragile, keep away from rain.
"""

from collections.abc import Sequence
from typing import Literal

import numpy as np

from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.geometry.solids import Outline, prism
from warehouse_sim.schema import Part

Side = Literal["-x", "+x", "-y", "+y"]
Mark = Literal["up", "fragile", "dry"]
Shapes = tuple[Outline, ...]

_STROKES: dict[str, tuple[tuple[float, float, float, float], ...]] = {
    "A": ((0, 0, 1, 6), (3, 0, 4, 6), (1, 5, 3, 6), (1, 2, 3, 3)),
    "C": ((0, 0, 1, 6), (1, 5, 4, 6), (1, 0, 4, 1)),
    "E": ((0, 0, 1, 6), (1, 5, 4, 6), (1, 2.5, 3.5, 3.5), (1, 0, 4, 1)),
    "H": ((0, 0, 1, 6), (3, 0, 4, 6), (1, 2.5, 3, 3.5)),
    "I": ((1.5, 0, 2.5, 6),),
    "L": ((0, 0, 1, 6), (1, 0, 4, 1)),
    "N": ((0, 0, 1, 6), (3, 0, 4, 6), (1, 5, 3, 6)),
    "O": ((0, 0, 1, 6), (3, 0, 4, 6), (1, 5, 3, 6), (1, 0, 3, 1)),
    "P": ((0, 0, 1, 6), (1, 5, 4, 6), (3, 2, 4, 5), (1, 2, 3, 3)),
    "S": ((0, 0, 4, 1), (3, 1, 4, 3.5), (0, 2.5, 3, 3.5), (0, 3.5, 1, 6), (1, 5, 4, 6)),
    "T": ((1.5, 0, 2.5, 5), (0, 5, 4, 6)),
    "U": ((0, 0, 1, 6), (3, 0, 4, 6), (1, 0, 3, 1)),
    "B": ((0, 0, 1, 6), (1, 5, 3.5, 6), (1, 2.5, 3.5, 3.5), (1, 0, 3.5, 1), (3, 1, 4, 2.5), (3, 3.5, 4, 5)),
    "G": ((0, 0, 1, 6), (1, 5, 4, 6), (1, 0, 4, 1), (3, 1, 4, 3), (2, 2.5, 3, 3.5)),
    "K": ((0, 0, 1, 6), (1, 2.5, 2, 3.5), (2, 3, 3, 4.5), (3, 4.5, 4, 6), (2, 1.5, 3, 3), (3, 0, 4, 1.5)),
    "V": ((0, 1, 1, 6), (3, 1, 4, 6), (1, 0, 3, 1)),
    "Y": ((0, 3.5, 1, 6), (3, 3.5, 4, 6), (0, 2.5, 4, 3.5), (1.5, 0, 2.5, 2.5)),
    "0": ((0, 0, 1, 6), (3, 0, 4, 6), (1, 5, 3, 6), (1, 0, 3, 1)),
    "1": ((2, 0, 3, 6), (1, 4.5, 2, 5.5)),
    "2": ((0, 5, 4, 6), (3, 3.5, 4, 5), (0, 2.5, 4, 3.5), (0, 1, 1, 2.5), (0, 0, 4, 1)),
    "3": ((0, 5, 4, 6), (3, 1, 4, 5), (1, 2.5, 3, 3.5), (0, 0, 4, 1)),
    "4": ((0, 2.5, 1, 6), (1, 2.5, 3, 3.5), (3, 0, 4, 6)),
    "5": ((0, 5, 4, 6), (0, 3.5, 1, 5), (0, 2.5, 4, 3.5), (3, 1, 4, 2.5), (0, 0, 4, 1)),
    "6": ((0, 0, 1, 6), (1, 5, 4, 6), (1, 2.5, 4, 3.5), (3, 1, 4, 2.5), (1, 0, 4, 1)),
    "7": ((0, 5, 4, 6), (3, 0, 4, 5)),
    "8": ((0, 0, 1, 6), (3, 0, 4, 6), (1, 5, 3, 6), (1, 2.5, 3, 3.5), (1, 0, 3, 1)),
    "9": ((0, 2.5, 1, 6), (3, 0, 4, 6), (1, 5, 3, 6), (1, 2.5, 3, 3.5), (0, 0, 3, 1)),
    " ": (),
}
"""Capitals and figures of bars on a grid of 4 x 6 squares: left, bottom, right, top."""
_LETTER_PITCH = 5.0


def rectangle(left: float, bottom: float, right: float, top: float) -> Outline:
    """Return a rectangle by its edges (m)."""
    return (left, bottom), (right, bottom), (right, top), (left, top)


def moved(shapes: Shapes, x: float, y: float) -> Shapes:
    """Return ``shapes`` shifted (m)."""
    return tuple(tuple((u + x, v + y) for u, v in shape) for shape in shapes)


def word(text: str, height: float) -> Shapes:
    """Return capitals and figures of ``height`` (m), centred."""
    unit = height / 6
    left = -word_width(text, height) / 2
    return tuple(
        rectangle(
            left + (i * _LETTER_PITCH + a) * unit,
            b * unit - height / 2,
            left + (i * _LETTER_PITCH + c) * unit,
            d * unit - height / 2,
        )
        for i, letter in enumerate(text)
        for a, b, c, d in _STROKES[letter]
    )


def word_width(text: str, height: float) -> float:
    """Return the width (m) of a word of capitals."""
    return (len(text) * _LETTER_PITCH - 1.0) * height / 6


def barcode(number: int, width: float, height: float, bars: int = 18) -> Shapes:
    """Return the bars of a code that stands for ``number``; bars and gaps are 1-3 modules wide, as in ITF-14."""
    modules = np.random.default_rng(number).integers(1, 4, 2 * bars - 1)
    edges = np.concatenate([[0], np.cumsum(modules)]) / modules.sum() * width - width / 2
    return tuple(
        rectangle(float(a), -height / 2, float(b), height / 2) for a, b in zip(edges[::2], edges[1::2], strict=True)
    )


def text_lines(width: float, height: float, fractions: Sequence[float]) -> Shapes:
    """Return lines too small to read, one per entry of ``fractions`` of the width (m), down from ``height`` (m)."""
    pitch = height / len(fractions)
    tops = [height / 2 - i * pitch for i in range(len(fractions))]
    return tuple(
        rectangle(-width / 2, top - 0.6 * pitch, -width / 2 + fraction * width, top)
        for top, fraction in zip(tops, fractions, strict=True)
    )


def handling_mark(mark: Mark, height: float) -> Shapes:
    """Return one of the marks of ISO 780, ``height`` (m) high and less than that wide, centred."""
    return tuple(tuple((height * x, height * y) for x, y in shape) for shape in _MARKS[mark])


def on_side(
    shapes: Shapes, side: Side, size: Sequence[float], material: str, recess: float, depth: float
) -> list[Part]:
    """Put shapes on the side of a centred box, as slabs whose outer faces lie ``recess`` (m) below its surface.

    Args:
        shapes: Polygons in the side's plane (m).
        side: Which side.
        size: Outer edges of the box (m).
        material: Name of the slabs' material.
        recess: How far the slabs' outer faces lie inside the box (m).
        depth: Thickness of the slabs (m).
    """
    axis, sign = "xy".index(side[1]), -1.0 if side[0] == "-" else 1.0
    out, up = sign * np.eye(3)[axis], np.array([0.0, 0.0, 1.0])
    rotation = np.column_stack([np.cross(up, out), up, out])
    T_object_side = make_transform(rotation, out * (size[axis] / 2 - recess - depth / 2))
    return [Part(prism(shape, depth), np.ones(3), T_object_side, material) for shape in shapes]


def _arrow(x: float) -> Outline:
    points = ((-0.06, -0.34), (0.06, -0.34), (0.06, 0.2), (0.16, 0.2), (0.0, 0.5), (-0.16, 0.2), (-0.06, 0.2))
    return tuple((x + u, v) for u, v in points)


def _dome(count: int = 8) -> Outline:
    angles = np.linspace(0.0, np.pi, count)
    return tuple((0.38 * float(np.cos(a)), 0.1 + 0.34 * float(np.sin(a))) for a in angles)


_GLASS: Outline = (
    (-0.2, -0.5), (0.2, -0.5), (0.2, -0.43), (0.045, -0.38), (0.045, -0.08), (0.2, 0.06), (0.28, 0.5), (0.1, 0.5),
    (0.02, 0.26), (0.0, 0.5), (-0.28, 0.5), (-0.2, 0.06), (-0.045, -0.08), (-0.045, -0.38), (-0.2, -0.43),
)  # fmt: skip
_MARKS: dict[Mark, Shapes] = {
    "up": (_arrow(-0.2), _arrow(0.2), rectangle(-0.4, -0.5, 0.4, -0.42)),
    "fragile": (_GLASS,),
    "dry": (
        _dome(),
        rectangle(-0.025, -0.42, 0.025, 0.1),
        rectangle(-0.13, -0.5, 0.025, -0.42),
        rectangle(-0.2, 0.46, -0.17, 0.56),
        rectangle(0.17, 0.46, 0.2, 0.56),
    ),
}
