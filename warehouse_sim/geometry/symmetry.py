"""Which turns leave an object as it is: finite groups of rigid transforms, declared or measured on the CAD surface.

A declared group says which poses look the same in colour. Without colour more poses do: a printed carton turned by half
is the same cuboid.
"""

from dataclasses import dataclass
from itertools import permutations, product
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.geometry.mesh import TriangleMesh, sample_surface
from warehouse_sim.geometry.pose import (
    Transform,
    Transforms,
    make_transform,
    rotation_x,
    rotation_y,
    rotation_z,
    transform_points,
)

if TYPE_CHECKING:
    from scipy.spatial import KDTree

_TURN = {"x": rotation_x, "y": rotation_y, "z": rotation_z}


@dataclass(frozen=True, eq=False)
class SymmetryGroup:
    """A finite group; ``transforms[0]`` is the identity and the set is closed under composition."""

    transforms: Transforms

    @classmethod
    def trivial(cls) -> "SymmetryGroup":
        """Return the group of the identity alone."""
        return cls(np.eye(4)[None])

    @classmethod
    def turns(cls, axis: str, count: int) -> "SymmetryGroup":
        """Return ``count`` equal turns about an axis ("x", "y" or "z") through the origin."""
        rotations = [_TURN[axis](2 * np.pi * k / count) for k in range(count)]
        # Exact zeros and ones for quarter turns: the matrices are written to files that people read.
        exact = [np.where(np.abs(r - np.round(r)) < 1e-12, np.round(r), r) for r in rotations]
        return cls(make_transform(np.stack(exact)))

    @classmethod
    def cuboid(cls) -> "SymmetryGroup":
        """Return the four rotations of a box with three different edges: identity and three half-turns."""
        half_turns = [cls.turns(axis, 2).transforms[1] for axis in "xyz"]
        return cls(np.stack([np.eye(4), *half_turns]))

    def __len__(self) -> int:
        return len(self.transforms)

    def equivalents(self, T_a_object: Transform) -> Transforms:
        """Return every pose that looks the same as ``T_a_object``: ``T_a_object @ S`` for S in the group."""
        return T_a_object @ self.transforms


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
    # Imported on use: it takes longer to import than all of geometry.
    from scipy.spatial import KDTree

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


def _distance(tree: "KDTree", points: Float[np.ndarray, "n 3"]) -> float:
    return float(np.mean(tree.query(points)[0]))


def _holds(group: SymmetryGroup, other: SymmetryGroup) -> bool:
    apart = np.abs(group.transforms[:, None] - other.transforms[None]).max(axis=(2, 3))
    return bool((apart.min(axis=0) < 1e-6).all())
