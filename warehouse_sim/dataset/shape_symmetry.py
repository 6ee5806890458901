"""The turns that leave an object's shape as it is, whatever is printed on it: measured on the CAD surface.

A declared symmetry group says which poses look the same in colour. Without colour more poses do: a printed carton
turned by half is the same cuboid.
"""

from itertools import permutations, product

import numpy as np
from jaxtyping import Float
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
    rng = np.random.default_rng(0)
    surface, tested = (sample_surface(mesh, count, rng)[0] for count in (_SURFACE_SAMPLES, _TESTED_SAMPLES))
    tree, extent = KDTree(surface), np.abs(mesh.vertices).max(axis=0)
    limit = _distance(tree, tested) + _SURFACE_TOLERANCE * 2.0 * float(np.linalg.norm(extent))
    found = [
        T
        for T in _box_turns()
        if np.abs(np.abs(T[:3, :3]) @ extent - extent).max() <= 2.0 * _EDGE_TOLERANCE * extent.max()
        and _distance(tree, transform_points(T, tested)) <= limit
    ]
    group = SymmetryGroup(np.stack(found))
    larger = len(group) > len(declared) and _holds(group, declared) and _is_closed(group)
    return group if larger else declared


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


def _is_closed(group: SymmetryGroup) -> bool:
    products = group.transforms[:, None] @ group.transforms[None]
    return _holds(group, SymmetryGroup(products.reshape(-1, 4, 4)))
