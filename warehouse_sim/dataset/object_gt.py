"""Whether what objects.json says of an object is true of its meshes: size, diameter, symmetries, pockets.

Scores rest on these numbers, so that scoring asks, too. Each is held against the surface itself, once an object.
"""

import numpy as np
from jaxtyping import Float
from scipy.spatial import ConvexHull, QhullError

from warehouse_sim.dataset.objects import FACES, ObjectInfo
from warehouse_sim.geometry.mesh import TriangleMesh, diameter, sample_surface
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.geometry.symmetry import is_closed, surface_kept
from warehouse_sim.schema import Pocket

_SAME_PLACE = 1e-3
"""Metres that a mesh may differ from its nominal box, or a pocket from its side."""
_SAME_FRACTION = 0.01
"""The same as a fraction of the object, for meshes that were made elsewhere with fewer points."""
_SAME_SURFACE = 1e-5
"""How far areas and volumes of the two meshes may differ, as fractions: they are stored in 32 bits."""
_INWARDS = -0.01
"""Fraction of the object's box that a mesh encloses with its faces inwards."""
_SAMPLES = 20_000
_CLEAR = 0.002
"""Metres from a pocket's walls within which a surface may lie."""
_WITHOUT_POCKETS_FROM = 1000
"""Users' own objects have these numbers; they declare no pockets, whatever their class."""


def geometry_problems(info: ObjectInfo) -> list[str]:
    """Return what is wrong with an object's numbers, empty if nothing is.

    Raises:
        DatasetError: A mesh is missing or cannot be read.
    """
    if not info.has_cad:  # It is the points in its box, and there is nothing that they could contradict.
        return []
    mesh, points = info.mesh(), info.metric_mesh()
    if not mesh.face_areas().sum() > 0.0:
        return ["its mesh has no area"]
    if info.is_scan:
        return _wrong_lengths(info, points)  # a scan may have holes or faces inwards, and poses are scored all the same
    return [
        *_wrong_lengths(info, points),
        *inside_out(info, mesh),
        *_different_surfaces(info, mesh, points),
        *_wrong_symmetries(info, mesh),
        *_wrong_pockets(info, mesh),
    ]


def hull_corners(points: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "h 3"]:
    """Return the corners of the convex hull; of points in one plane, which have none in space, all."""
    try:
        return points[ConvexHull(points).vertices]
    except QhullError:
        return points


def _wrong_lengths(info: ObjectInfo, points: TriangleMesh) -> list[str]:
    problems = []
    low, high = points.vertices.min(axis=0), points.vertices.max(axis=0)
    ends = [high - info.size / 2.0, low + info.size / 2.0]
    # Others' models have their origin where their makers put it.
    apart = np.abs(high - low - info.size if info.is_scan else ends).max()
    if apart > _SAME_PLACE + _SAME_FRACTION * info.size.max():
        edges = ", ".join(f"{edge:.4g}" for edge in high - low)
        problems.append(f"size is {info.size.tolist()} m, the mesh has {edges} m or lies off its centre")
    measured = diameter(hull_corners(points.vertices))
    if abs(measured - info.diameter) > _SAME_FRACTION * measured:
        problems.append(f"diameter is {info.diameter:.6g} m, the mesh has {measured:.6g} m")
    return problems


def _different_surfaces(info: ObjectInfo, mesh: TriangleMesh, points: TriangleMesh) -> list[str]:
    """Compare the CAD surface with the same surface meshed evenly, by what any change of shape changes."""
    areas = [item.face_areas().sum() for item in (mesh, points)]
    volumes = [_volume(item) for item in (mesh, points)]
    same_area = abs(areas[0] - areas[1]) <= _SAME_SURFACE * areas[0]
    # An open surface encloses nothing; its area times its width bounds what rounding can do.
    same_volume = abs(volumes[0] - volumes[1]) <= _SAME_SURFACE * areas[0] * info.size.min()
    return [] if same_area and same_volume else ["the meshes in models and models_eval are not the same surface"]


def inside_out(info: ObjectInfo, mesh: TriangleMesh) -> list[str]:
    """Look at the sign of the enclosed volume; a scan with holes encloses little of either sign."""
    fraction = _volume(mesh) / float(np.prod(info.size))
    return (
        ["the mesh is inside out: its faces look inwards, as those of a mirrored one do"] if fraction < _INWARDS else []
    )


def _volume(mesh: TriangleMesh) -> float:
    """Return the enclosed volume (m^3) by the divergence theorem."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def _wrong_symmetries(info: ObjectInfo, mesh: TriangleMesh) -> list[str]:
    problems, motions = [], info.symmetry.transforms
    if not np.allclose(motions[0], np.eye(4)):
        problems.append("symmetries must start with the identity")
    if not is_closed(info.symmetry):
        problems.append("symmetries are not closed under composition")
    moved = np.flatnonzero(~surface_kept(mesh, motions))
    problems += [f"symmetries[{index}] moves the surface elsewhere" for index in moved]
    for index, T in enumerate(motions):
        if not all(_is_among(pocket, T, info.pockets) for pocket in info.pockets):
            problems.append(f"symmetries[{index}] moves a pocket to where there is none")
    return problems


def _wrong_pockets(info: ObjectInfo, mesh: TriangleMesh) -> list[str]:
    problems = []
    if info.class_name == "pallet" and info.obj_id < _WITHOUT_POCKETS_FROM and not info.pockets:
        problems.append("a pallet has pockets, pockets is empty")
    surface = sample_surface(mesh, _SAMPLES, np.random.default_rng(0))[0]
    for index, pocket in enumerate(info.pockets):
        where, T, normal = f"pockets[{index}]", pocket.T_object_pocket, np.array(FACES[pocket.face])
        beside = abs(float(T[:3, 3] @ normal) - float(np.abs(normal) @ info.size) / 2.0)
        if not np.allclose(T[:3, 0], -normal) or abs(T[2, 2]) < 1.0 - 1e-6 or beside > _SAME_PLACE:
            problems.append(f"{where}: does not open on the face {pocket.face}")
        elif (np.abs(_corners(pocket)) > info.size / 2.0 + _SAME_PLACE).any():
            problems.append(f"{where}: leaves the object, which is {info.size.tolist()} m")
        elif _blocked(pocket, surface):
            problems.append(f"{where}: the surface stands inside it")
    return problems


def _is_among(pocket: Pocket, motion: Transform, pockets: tuple[Pocket, ...]) -> bool:
    moved = motion @ pocket.T_object_pocket
    return any(
        np.abs(moved - other.T_object_pocket).max() < _SAME_PLACE
        and np.abs(pocket.size - other.size).max() < _SAME_PLACE
        for other in pockets
    )


def _corners(pocket: Pocket) -> Float[np.ndarray, "8 3"]:
    depth, width, height = pocket.size
    ends = np.array(
        [[x, y, z] for x in (0.0, depth) for y in (-width / 2, width / 2) for z in (-height / 2, height / 2)]
    )
    return transform_points(pocket.T_object_pocket, ends)


def _blocked(pocket: Pocket, surface: Float[np.ndarray, "n 3"]) -> bool:
    depth, width, height = pocket.size
    x, y, z = transform_points(invert(pocket.T_object_pocket), surface).T
    along = (x > _CLEAR) & (x < depth - _CLEAR)
    return bool((along & (np.abs(y) < width / 2 - _CLEAR) & (np.abs(z) < height / 2 - _CLEAR)).any())
