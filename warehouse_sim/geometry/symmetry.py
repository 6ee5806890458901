"""Which turns leave the shape of an object as it is: finite groups of rigid transforms."""

from dataclasses import dataclass

import numpy as np

from warehouse_sim.geometry.pose import Transform, Transforms, make_transform, rotation_x, rotation_y, rotation_z

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
