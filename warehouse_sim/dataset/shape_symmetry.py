"""The turns that leave an object's shape as it is, whatever is printed on it: measured on the CAD surface.

A declared symmetry group says which poses look the same in colour. Without colour more poses do: a printed carton
turned by half is the same cuboid.
"""

from itertools import permutations, product

import numpy as np
from jaxtyping import Bool, Float
from scipy.spatial import KDTree

from warehouse_sim.geometry.mesh import TriangleMesh, sample_surface
from warehouse_sim.geometry.pose import Transforms, make_transform, transform_points
from warehouse_sim.geometry.symmetry import SymmetryGroup

_SURFACE_SAMPLES, _TESTED_SAMPLES = 20_000, 2_000
_EDGE_TOLERANCE = 0.005
"""How much of the longest edge the box of an object may change under a turn."""
_SURFACE_TOLERANCE = 0.00125
"""How much farther from the surface, on average and in diameters of the box, a turn may bring its points: chance and a
label's thickness stay below 0.0005 over the catalog, other turns of its targets above 0.002."""


def shape_symmetry(mesh: TriangleMesh, declared: SymmetryGroup) -> SymmetryGroup:
    """Return the group of the shape: quarter and half turns of its box that leave the surface where it was.

    Faces inside a solid, where parts overlap, count as surface: a turn that moves those is not found. A knob on a large
    object is overlooked.

    Args:
        mesh: CAD surface (m) in the object frame, whose origin is the centre of its box.
        declared: The group that the object declares, which is returned unless the shape's holds all of it and more.
    """
    extent, turns = np.abs(mesh.vertices).max(axis=0), _box_turns()
    moved_edges = np.abs(np.abs(turns[:, :3, :3]) @ extent - extent).max(axis=1)
    likely = turns[moved_edges <= 2.0 * _EDGE_TOLERANCE * extent.max()]
    group = SymmetryGroup(likely[surface_kept(mesh, likely)])
    larger = len(group) > len(declared) and _holds(group, declared) and is_closed(group)
    return group if larger else declared


def surface_kept(mesh: TriangleMesh, motions: Transforms) -> Bool[np.ndarray, " n"]:
    """Return which motions, "n 4 4", bring sampled points of a surface back onto it."""
    rng = np.random.default_rng(0)
    surface, tested = (sample_surface(mesh, count, rng)[0] for count in (_SURFACE_SAMPLES, _TESTED_SAMPLES))
    # Few points are looked up: a balanced tree takes longer to build than it saves.
    tree, extent = KDTree(surface, compact_nodes=False, balanced_tree=False), np.abs(mesh.vertices).max(axis=0)
    limit = _distance(tree, tested) + _SURFACE_TOLERANCE * 2.0 * float(np.linalg.norm(extent))
    return np.array([_distance(tree, transform_points(T, tested)) <= limit for T in motions])


def is_closed(group: SymmetryGroup) -> bool:
    """Return whether any two motions of a group, one after the other, make a third of it."""
    return all(_holds(group, SymmetryGroup(T @ group.transforms)) for T in group.transforms)


def _box_turns() -> Transforms:
    """Return the 24 rotations of a cube, the identity first."""
    signed = [
        np.eye(3)[list(order)] * np.array(signs)[:, None]
        for order in permutations(range(3))
        for signs in product((1.0, -1.0), repeat=3)
    ]
    # Adding zero leaves no negative zeros, which people would read in files.
    return make_transform(np.stack([R for R in signed if np.linalg.det(R) > 0.0]) + 0.0)


def _distance(tree: KDTree, points: Float[np.ndarray, "n 3"]) -> float:
    return float(np.mean(tree.query(points)[0]))


def _holds(group: SymmetryGroup, other: SymmetryGroup) -> bool:
    apart = np.abs(group.transforms[:, None] - other.transforms[None]).max(axis=(2, 3))
    return bool((apart.min(axis=0) < 1e-6).all())
