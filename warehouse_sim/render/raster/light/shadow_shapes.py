"""What stands for finely shaped pieces in the shadow maps: their convex hulls, of few faces.

A map of a hall has texels of centimetres, and holds back faces alone: what lies inside of a hull is not shaded by it,
so that a hull may fill the dish of a lid or the dents of a sack. Sacks, drums, totes in the racks behind and bulged
cartons are most of the triangles of a warehouse; as hulls they are a tenth of them.
"""

from functools import cache
from weakref import WeakKeyDictionary

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError

from warehouse_sim.geometry.mesh import TriangleMesh, merge
from warehouse_sim.geometry.separation import overlapping_pairs
from warehouse_sim.render.raster.meshes.parts import PartTable

_MANY_FACES = 48
"""Pieces of fewer faces stay as they are."""
_DENT = 0.13
"""How far a piece may lie inside its hull, as a fraction of its shortest edge."""
_FULL = 0.85
"""Least fraction of its hull that a piece fills: sacks and drums do, profiles and open boxes do not."""
_ROUNDED = 0.05
"""How far a hull of fewer points may lie inside the full one, as a fraction of the piece's shortest edge."""
_DIRECTIONS = 24
_INTO = 0.0005
"""Bounding boxes overlap that reach into each other by twice this (m)."""

_known: WeakKeyDictionary[TriangleMesh, dict[bool, TriangleMesh]] = WeakKeyDictionary()


def shadow_shape(mesh: TriangleMesh, filled: bool = False) -> TriangleMesh:
    """Return what casts the shadow of ``mesh``: the mesh itself, or one of at most half as many faces.

    Args:
        mesh: A part.
        filled: Whether every connected piece may be taken for its hull, as boxes in a stack may whose insides nobody
            sees; otherwise only nearly convex pieces are.
    """
    shapes = _known.setdefault(mesh, {})
    if filled not in shapes:
        shapes[filled] = _shadow_shape(mesh, filled)
    return shapes[filled]


def _shadow_shape(mesh: TriangleMesh, filled: bool) -> TriangleMesh:
    if len(mesh.faces) <= _MANY_FACES:
        return mesh
    piece_of = _pieces(mesh)
    if filled:
        piece_of = _overlapping(mesh, piece_of)
    kept, shapes = np.ones(len(mesh.faces), bool), []
    for piece in np.flatnonzero(np.bincount(piece_of) > _MANY_FACES):
        members = piece_of == piece
        hull = _hull(_compact(mesh.vertices, mesh.faces[members]), filled)
        if hull is not None:
            kept &= ~members
            shapes.append(hull)
    whole = merge([_compact(mesh.vertices, mesh.faces[kept]), *shapes])
    return whole if 2 * len(whole.faces) <= len(mesh.faces) else mesh


def _pieces(mesh: TriangleMesh) -> Int[np.ndarray, " m"]:
    """Return for each face the number of its connected piece; vertices at the same place count as one."""
    places = np.round(mesh.vertices, 6) + 0.0
    _, welded = np.unique(places.view(np.dtype((np.void, places.itemsize * 3))), return_inverse=True)
    faces = welded.reshape(-1)[mesh.faces]
    ends = np.concatenate([faces[:, :2], faces[:, 1:]])
    meet = coo_array((np.ones(len(ends), bool), (ends[:, 0], ends[:, 1])), shape=(len(places), len(places)))
    return connected_components(meet, directed=False)[1][faces[:, 0]]


def _overlapping(mesh: TriangleMesh, piece_of: Int[np.ndarray, " m"]) -> Int[np.ndarray, " m"]:
    """Return the pieces with one number for those whose bounding boxes reach into each other, as walls and ribs do."""
    count = int(piece_of.max()) + 1
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    points = mesh.vertices[mesh.faces]
    np.minimum.at(low, piece_of, points.min(axis=1))
    np.maximum.at(high, piece_of, points.max(axis=1))
    there = low[:, 0] <= high[:, 0]
    low[~there] = high[~there] = 0.0
    pairs = overlapping_pairs(low + _INTO, high - _INTO, low + _INTO, high - _INTO)
    meet = coo_array((np.ones(len(pairs), bool), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return connected_components(meet, directed=False)[1][piece_of]


def _compact(vertices: Float[np.ndarray, "n 3"], faces: Int[np.ndarray, "m 3"]) -> TriangleMesh:
    used, local = np.unique(faces, return_inverse=True)
    return TriangleMesh(vertices[used], local.reshape(-1, 3).astype(np.int32))


def _hull(piece: TriangleMesh, filled: bool) -> TriangleMesh | None:
    """Return the hull of a piece by few of its points; None where it is no hull's shape."""
    points = piece.vertices
    extent = np.ptp(points, axis=0)
    thin = float(extent.min())
    try:
        hull, corners = _rounded(points, extent, _ROUNDED * thin)
    except QhullError:
        return None  # flat, or too thin to have an inside
    solid = _FULL * hull.volume <= _volume(piece) and -_beyond(hull, points).max(axis=1).min() <= _DENT * thin
    return _outward(hull, corners) if filled or solid else None


def _volume(piece: TriangleMesh) -> float:
    """Return the volume (m^3) inside a closed mesh, by the divergence theorem."""
    a, b, c = np.moveaxis(piece.vertices[piece.faces] - piece.vertices[0], 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def _rounded(
    points: Float[np.ndarray, "n 3"], extent: Float[np.ndarray, " 3"], error: float
) -> tuple[ConvexHull, Float[np.ndarray, "k 3"]]:
    """Return a hull of some of the points, and these; no other point is further out of it than ``error`` (m).

    It begins with the outermost points in directions that are even on the piece stretched to a cube, and gains those
    that lie farthest beyond a face until none is too far.
    """
    chosen = np.unique((points / np.maximum(extent, 1e-9) @ _directions().T).argmax(axis=0))
    while True:
        hull = ConvexHull(points[chosen])
        beyond = _beyond(hull, points)
        far = np.unique(beyond.argmax(axis=0)[beyond.max(axis=0) > error])
        more = np.union1d(chosen, far)
        if len(more) == len(chosen):
            return hull, points[chosen]
        chosen = more


def _beyond(hull: ConvexHull, points: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n f"]:
    """Return how far each point lies beyond the plane of each face of a hull (m)."""
    return np.asarray(points @ hull.equations[:, :3].T + hull.equations[:, 3])


def _outward(hull: ConvexHull, points: Float[np.ndarray, "n 3"]) -> TriangleMesh:
    """Return the hull as a mesh whose faces are counter-clockwise seen from outside."""
    faces = hull.simplices
    a, b, c = points[faces[:, 0]], points[faces[:, 1]], points[faces[:, 2]]
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    return _compact(points, np.where(inward[:, None], faces[:, ::-1], faces))


@cache
def _directions() -> Float[np.ndarray, "k 3"]:
    """Return directions spread over the sphere, the axes and the diagonals among them.

    A spherical Fibonacci lattice (Swinbank and Purser 2006), with what finds the corners of boxes.
    """
    number = np.arange(_DIRECTIONS) + 0.5
    z = 1.0 - 2.0 * number / _DIRECTIONS
    turn = np.pi * (1.0 + np.sqrt(5.0)) * number
    ring = np.sqrt(1.0 - z * z)
    spread = np.stack([ring * np.cos(turn), ring * np.sin(turn), z], axis=1)
    steps = np.array(np.meshgrid([-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0])).reshape(3, -1).T
    corners = steps[np.abs(steps).sum(axis=1) > 0.0]
    return np.concatenate([corners / np.linalg.norm(corners, axis=1, keepdims=True), spread])


_WIDE = 1.0
"""A sheet reaches at least so far from its middle in both directions (m)."""
_THIN = 0.15
"""And at most so far across (m)."""
_RELIEF_FACES = 64
"""Sheets of more faces have relief."""
_CORE = 0.3
"""Fraction of a sheet's thickness that casts its shadow."""


def thinned_sheets(table: PartTable, records: np.ndarray) -> np.ndarray:
    """Return ``records`` with wide sheets that have relief thinned to their core.

    The ribs of a wall are finer than the texels of a map that shows a hall, so their shadows on the wall would be
    patterns of the two grids. The core lies inside of the sheet, below the feet of its ribs: it shades all that the
    sheet does, to a few centimetres, but not the sheet.

    Args:
        table: The parts.
        records: The table placed in some frame.
    """
    rows = _relief_rows(table)
    if len(rows) == 0:
        return records
    axis = table.half_size[rows].argmin(axis=1)
    thinned = records.copy()
    thinned["scale"][rows, axis] *= _CORE
    # About the sheet's middle; the rotation is stored by its columns.
    shift = (1.0 - _CORE) * table.local_centre[rows, axis]
    thinned["translation"][rows] += records["rotation"][rows, axis] * shift[:, None].astype(np.float32)
    return thinned


def _relief_rows(table: PartTable) -> Int[np.ndarray, " k"]:
    """Return the rows of wide sheets with relief."""
    faces = np.zeros(len(table), int)
    for rows, mesh in zip(table.rows_of_mesh, table.meshes, strict=True):
        faces[rows] = len(mesh.faces)
    thinnest, middle, _ = np.sort(table.half_size, axis=1).T
    return np.flatnonzero((thinnest < _THIN) & (middle > _WIDE) & (faces > _RELIEF_FACES))
