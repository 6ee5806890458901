"""What is branded, stencilled or stamped on the sides of a pallet.

EPAL pallets bear "EPAL" in an oval on the corner blocks of the long sides, or on the steel brackets in their place, and
the IPPC mark of heat treatment (ISPM 15) with the licence number on the central blocks (epal-pallets.org). Wooden
pallets of other makes bear the IPPC mark alone, pool pallets the name of their owner.
"""

from functools import cache

import numpy as np

from warehouse_sim.catalog.pallets.wear.damage import Member
from warehouse_sim.catalog.parts import solid_part
from warehouse_sim.geometry.mesh import TriangleMesh, merge, unit_box
from warehouse_sim.geometry.solids import unit_tube
from warehouse_sim.schema import ObjectModel

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


SKIN = 0.0004
"""How far a brand stands proud of the wood (m)."""

_IPPC = (("IPPC", "PL-4915", "HT"), ("DE-NW", "49013", "HT"), ("IPPC", "LT-907", "HT"))
_IPPC_US = (("IPPC", "US-497", "HT"),)
_OVAL_SIZE, _IPPC_SIZE, _OWNER_SIZE = (0.095, 0.050), (0.088, 0.056), (0.105, 0.042)
_LEAST_FACE = 0.09
_SAME = 1e-6
_MARKED = ("block", "bracket", "stringer")
"""Roles of the pieces that bear marks."""


def branded(members: list[Member], model: ObjectModel, legible: float, rng: np.random.Generator) -> list[Member]:
    """Return the members with the marks of their make, each of which is legible with probability ``legible``."""
    licence = int(rng.integers(len(_IPPC)))
    return [_branded(member, model, licence, legible, rng) for member in members]


def _branded(member: Member, model: ObjectModel, licence: int, legible: float, rng: np.random.Generator) -> Member:
    (x, y, z), (length, width, height) = member.centre, _outer_size(member)
    half = float(model.size[1]) / 2
    tall = height > 0.05 and length >= _LEAST_FACE and member.role in _MARKED
    side = float(np.sign(y))
    if not tall or abs(abs(y) + width / 2 - half) > _SAME:
        return member
    mark = _mark(model, abs(x) < _SAME, licence)
    if mark is None or rng.random() >= legible:
        return member
    mesh, size, material = mark
    # Readable from outside: x of the text to the reader's right, y up, z outwards.
    rotation = np.array([[-side, 0.0, 0.0], [0.0, 0.0, side], [0.0, 1.0, 0.0]])
    centre = (x, side * half, z)
    return member.with_parts(solid_part(mesh, (*size, 2 * SKIN), centre, material, rotation))


def _outer_size(member: Member) -> tuple[float, float, float]:
    """Return the edges (m) along x, y and z of the box around the piece as built."""
    vertices = member.body.placed().vertices
    x, y, z = vertices.max(axis=0) - vertices.min(axis=0)
    return float(x), float(y), float(z)


def _mark(model: ObjectModel, central: bool, licence: int) -> tuple[TriangleMesh, tuple[float, float], str] | None:
    """Return mesh, size (m) and material of the mark on a central or a corner block of this make."""
    if model.make == "EPAL":
        if central:
            return framed_brand(_IPPC[licence]), _IPPC_SIZE, "brand_mark"
        return oval_brand(model.make), _OVAL_SIZE, "brand_mark"
    if model.make == "POOL":
        return None if central else (lettering((model.make,)), _OWNER_SIZE, "stencil_white")
    return (framed_brand(_IPPC_US[0]), _IPPC_SIZE, "brand_mark") if central else None
