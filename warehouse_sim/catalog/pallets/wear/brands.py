"""What is branded, stencilled or stamped on the sides of a pallet.

EPAL pallets bear "EPAL" in an oval on the corner blocks of the long sides, or on the steel brackets in their place, and
the IPPC mark of heat treatment (ISPM 15) with the licence number on the central blocks (epal-pallets.org). Wooden
pallets of other makes bear the IPPC mark alone, pool pallets the name of their owner.
"""

import numpy as np

from warehouse_sim.catalog.pallets.wear.lettering import framed_brand, lettering, oval_brand
from warehouse_sim.catalog.pallets.wear.members import Member
from warehouse_sim.catalog.parts import solid_part
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.schema import ObjectModel

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
