"""Floor and walls: slabs plain or with joints, flat walls and clad ones, and wall modules with a dock opening.

Frame of all: origin at the centre of the bounding box, z up, x along a wall.
"""

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog.parts import Size, box_part, collision_boxes, fused, mesh_part, model_of, solid_box
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.schema import ObjectModel, Part

FLOOR_SIZE = (48.0, 48.0, 0.2)
"""Edges of the slab (m)."""
WALL_SIZE = (48.0, 0.2, 9.0)
"""Edges of a wall (m), x along it."""
MODULE_LENGTH = 6.0
"""Length of a wall module (m); eight make a wall."""
OPENING_WIDTH, OPENING_HEIGHT = 2.75, 3.0
"""Clear opening of a dock (m); a trailer is 2.55 m wide at most (96/53/EC)."""
PANEL = 6.0
"""Edge of the floor's panels between joints (m); 20-30 times the slab's thickness is the rule for sawn joints."""
_JOINT_WIDTH, _JOINT_DEPTH = 0.01, 0.02
_PLINTH = 0.4
_FRAME = 0.1  # around a dock's opening, on both faces of the wall
_RIB_PITCH, _RIB_DEPTH = 0.2, 0.035  # a trapezoidal sheet of the 35/207 kind, its pitch rounded so that modules fit
_LAYOUT = ((0.0, 0.0), (0.06, 0.0), (0.08, 1.0), (0.12, 1.0), (0.14, 0.0), (0.2, 0.0))
_SLABS = {"floor_slab_jointed": "concrete", "floor_slab_epoxy": "epoxy_grey"}


def floor_slab(name: str = "floor_slab") -> ObjectModel:
    """Build the concrete slab; its top is 0.1 m above its centre."""
    return model_of(name, "floor", 201, FLOOR_SIZE, (box_part(FLOOR_SIZE, (0.0, 0.0, 0.0), "concrete"),), turns=2)


def jointed_slab(name: str = "floor_slab_jointed") -> ObjectModel:
    """Build the slab with sawn joints, 10 mm wide, every 6 m: bare concrete or coated with epoxy."""
    parts = jointed_parts(FLOOR_SIZE, _SLABS[name])
    return model_of(name, "floor", 130, FLOOR_SIZE, parts, turns=2)


def jointed_parts(size: Size, material: str) -> tuple[Part, ...]:
    """Return the panels of a slab of edges ``size`` (m), about 6 m each, and what fills the joints between them."""
    length, width, thickness = size
    top = (thickness - _JOINT_DEPTH) / 2
    panels = [
        box_part((a, b, _JOINT_DEPTH), (x, y, top), material) for x, a in _panels(length) for y, b in _panels(width)
    ]
    filler = box_part((length, width, thickness - _JOINT_DEPTH), (0.0, 0.0, -_JOINT_DEPTH / 2), "floor_joint")
    return (*fused(panels), filler)


def _panels(length: float) -> list[tuple[float, float]]:
    """Return middle and length (m) of each panel along an edge of the slab."""
    edges = np.linspace(-length / 2, length / 2, max(round(length / PANEL), 1) + 1)
    starts, ends = edges[:-1].copy(), edges[1:].copy()
    starts[1:] += _JOINT_WIDTH / 2
    ends[:-1] -= _JOINT_WIDTH / 2
    return list(zip(((starts + ends) / 2).tolist(), (ends - starts).tolist(), strict=True))


def wall(name: str = "wall") -> ObjectModel:
    """Build a wall of painted panels above a concrete plinth."""
    length, thickness, height = WALL_SIZE
    parts = (
        box_part((length, thickness, _PLINTH), (0.0, 0.0, (_PLINTH - height) / 2), "concrete"),
        box_part((length, thickness, height - _PLINTH), (0.0, 0.0, _PLINTH / 2), "wall_paint"),
    )
    return model_of(name, "wall", 202, WALL_SIZE, parts, collision_boxes(parts), turns=2)


def wall_clad(name: str = "wall_clad") -> ObjectModel:
    """Build a wall of trapezoidal sheet with upright ribs on both faces above a concrete skirting."""
    return _clad(name, 131, WALL_SIZE[0])


def wall_module(name: str = "wall_module") -> ObjectModel:
    """Build 6 m of the clad wall."""
    return _clad(name, 132, MODULE_LENGTH)


def wall_module_dock(name: str = "wall_module_dock") -> ObjectModel:
    """Build 6 m of the clad wall with a dock opening in the middle, from the floor up, in a flat frame of steel."""
    _, thickness, height = WALL_SIZE
    foot, edge = -height / 2, OPENING_WIDTH / 2 + _FRAME
    lintel = foot + OPENING_HEIGHT
    parts, solid = [], []
    for sign in (-1.0, 1.0):
        left, right = sorted((sign * edge, sign * MODULE_LENGTH / 2))
        parts += _bay(left, right, foot)
        jamb = (_FRAME, thickness, OPENING_HEIGHT + _FRAME)
        parts.append(box_part(jamb, (sign * (edge - _FRAME / 2), 0.0, foot + jamb[2] / 2), "galvanised"))
        side = (MODULE_LENGTH - OPENING_WIDTH) / 2
        solid.append(solid_box((side, thickness, height), (sign * (MODULE_LENGTH - side) / 2, 0.0, 0.0)))
    parts.append(box_part((OPENING_WIDTH, thickness, _FRAME), (0.0, 0.0, lintel + _FRAME / 2), "galvanised"))
    parts.append(ribbed_sheet(-edge, edge, lintel + _FRAME, WALL_SIZE[2] / 2))
    above = height - OPENING_HEIGHT
    solid.append(solid_box((OPENING_WIDTH, thickness, above), (0.0, 0.0, (height - above) / 2)))
    return model_of(name, "wall", 133, (MODULE_LENGTH, thickness, height), fused(parts), solid, turns=2)


def _clad(name: str, obj_id: int, length: float) -> ObjectModel:
    size = (length, *WALL_SIZE[1:])
    parts = _bay(-length / 2, length / 2, -WALL_SIZE[2] / 2)
    return model_of(name, "wall", obj_id, size, parts, turns=2)


def _bay(left: float, right: float, foot: float) -> list[Part]:
    """Return skirting and sheet of the wall between ``left`` and ``right`` (m), from ``foot`` up."""
    size = (right - left, WALL_SIZE[1], _PLINTH)
    skirting = box_part(size, ((left + right) / 2, 0.0, foot + _PLINTH / 2), "concrete")
    return [skirting, ribbed_sheet(left, right, foot + _PLINTH, WALL_SIZE[2] / 2)]


def ribbed_sheet(left: float, right: float, foot: float, top: float) -> Part:
    """Return the ribbed sheet of a wall between ``left`` and ``right`` (m) from the height ``foot`` to ``top``."""
    x = profile_points(left, right)
    face = WALL_SIZE[1] / 2 - _RIB_DEPTH * (1.0 - profile(x))
    # Both faces are alike after a half turn, as the profile is even.
    mesh = profiled_solid(x, -face, face, top - foot)
    return mesh_part(mesh, "cladding", (0.0, 0.0, (foot + top) / 2))


def profile_points(left: float, right: float) -> Float[np.ndarray, " n"]:
    """Return ``left``, ``right`` and every fold of the sheet between them (m); folds are even about 0."""
    first, last = int(np.floor(left / _RIB_PITCH)) - 1, int(np.ceil(right / _RIB_PITCH)) + 1
    folds = np.array([number * _RIB_PITCH + at for number in range(first, last) for at, _ in _LAYOUT[1:-1]])
    inside = folds[(folds > left + 1e-9) & (folds < right - 1e-9)]
    return np.concatenate([[left], inside, [right]])


def profile(x: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
    """Return the sheet's profile at ``x`` (m): 0 in the troughs, 1 on the ribs; it repeats every 0.2 m."""
    places, heights = np.array(_LAYOUT).T
    return np.interp(np.round(x % _RIB_PITCH, 9), places, heights)


def profiled_solid(
    x: Float[np.ndarray, " n"], low: Float[np.ndarray, " n"], high: Float[np.ndarray, " n"], length: float
) -> TriangleMesh:
    """Return the watertight solid between two lines y = low(x) < high(x), extruded along z about 0 (m)."""
    count = len(x)
    y = np.concatenate([low, high, low, high])
    z = np.repeat([-length / 2, length / 2], 2 * count)
    a, b = np.arange(count - 1), np.arange(1, count)
    n, ends = count, np.array([0, count - 1])
    quads = [
        np.column_stack([a, b, b + 2 * n, a + 2 * n]),  # low side
        np.column_stack([b + n, a + n, a + 3 * n, b + 3 * n]),  # high side
        np.column_stack([b, a, a + n, b + n]),  # foot
        np.column_stack([a, b, b + n, a + n]) + 2 * n,  # top
        np.array([[n, 0, 2 * n, 3 * n], [0, n, 3 * n, 2 * n] + ends[1]]),  # both ends
    ]
    corners = np.concatenate(quads)
    faces = np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
    return TriangleMesh(np.column_stack([np.tile(x, 4), y, z]), faces.astype(np.int32))
