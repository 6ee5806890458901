"""The profile of a ribbed sheet, read from its mesh: what the geometry pass needs to filter its normals."""

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.schema import SceneSpec

_ALIKE = 1e-4
"""Lengths (m) that differ by less are the same."""
_FEWEST = 3
"""A sheet has at least so many ribs."""

_MOST_LEVELS = 8
"""A sheet is extruded: all its corners lie at its ends, or at an opening in it."""


@dataclass(frozen=True)
class Ribs:
    """A trapezoidal profile that repeats along x, with heights along y, extruded along z, in the mesh's frame."""

    pitch: float
    """Distance of the ribs (m)."""
    edges: tuple[float, float, float, float]
    """Foot and top of one rib's rising flank, top and foot of the falling one, along x (m)."""
    low: float
    """Height of the troughs, outwards from y = 0 (m)."""
    high: float
    """Height of the tops (m)."""
    side: int
    """Side that is ribbed: 1 at y > 0, -1 at y < 0 or seen from there, 0 = both alike."""


_known: WeakKeyDictionary[TriangleMesh, Ribs | None] = WeakKeyDictionary()


def ribs_of(mesh: TriangleMesh) -> Ribs | None:
    """Return the profile of ``mesh``, None when it is no ribbed sheet; found once a mesh."""
    if mesh not in _known:
        _known[mesh] = _find(mesh)
    return _known[mesh]


def ribbed_materials(scene: SceneSpec) -> frozenset[str]:
    """Return the names of the materials that ribbed sheets of ``scene`` are made of."""
    sheets = {
        name: [part for part in model.parts if ribs_of(part.mesh) is not None] for name, model in scene.models.items()
    }
    return frozenset(item.material_of(part) for item in scene.instances for part in sheets[item.model])


def _find(mesh: TriangleMesh) -> Ribs | None:
    if len(mesh.faces) < 8 * _FEWEST or len(np.unique(mesh.vertices[:, 2])) > _MOST_LEVELS:
        return None
    normals = mesh.face_normals()
    if not ((np.abs(normals[:, 2]) < _ALIKE) | (np.abs(normals[:, 2]) > 1.0 - _ALIKE)).all():
        return None
    found = [_profile(mesh, normals, side) for side in (1, -1)]
    one, other = found
    if one is not None and other is not None and _same(one, other):
        return Ribs(one.pitch, one.edges, one.low, one.high, 0)
    return one if other is None else other if one is None else None


def _profile(mesh: TriangleMesh, normals: Float[np.ndarray, "m 3"], side: int) -> Ribs | None:
    """Return the ribs on one side, None when there are none or they do not repeat."""
    faces = mesh.faces[side * normals[:, 1] > 0.05]
    points = mesh.vertices[np.unique(faces)][:, :2] * [1.0, side]
    points = np.unique(np.round(points, 6), axis=0)
    if len(points) < 4 * _FEWEST:
        return None
    low, high = points[:, 1].min(), points[:, 1].max()
    if high - low < _ALIKE:
        return None
    at_top, at_foot = high - points[:, 1] < _ALIKE, points[:, 1] - low < _ALIKE
    rising, falling = np.flatnonzero(at_foot[:-1] & at_top[1:]), np.flatnonzero(at_top[:-1] & at_foot[1:])
    if len(rising) < _FEWEST or len(falling) < _FEWEST:
        return None
    feet, x = points[rising, 0], points[:, 0]
    pitch = float(np.diff(feet).min())
    periods = (feet - feet[0]) / pitch
    fall = falling[falling > rising[0]][0]
    if np.abs(periods - np.round(periods)).max() > 0.01 or x[fall + 1] - feet[0] > pitch + _ALIKE:
        return None
    edges = float(feet[0]), float(x[rising[0] + 1]), float(x[fall]), float(x[fall + 1])
    return Ribs(pitch, edges, float(low), float(high), side)


def _same(one: Ribs, other: Ribs) -> bool:
    numbers = (one.pitch, *one.edges, one.low, one.high), (other.pitch, *other.edges, other.low, other.high)
    return bool(np.allclose(*numbers, rtol=0.0, atol=_ALIKE))
