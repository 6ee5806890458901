import numpy as np
import pytest

from warehouse_sim.geometry.pose import SymmetryGroup, make_transform, rotation_z


@pytest.mark.parametrize(
    ("group", "size"),
    [
        (SymmetryGroup.trivial(), 1),
        (SymmetryGroup.turns("z", 2), 2),
        (SymmetryGroup.turns("x", 5), 5),
        (SymmetryGroup.cuboid(), 4),
    ],
)
def test_groups_are_closed_and_start_with_identity(group, size) -> None:
    assert len(group) == size
    np.testing.assert_array_equal(group.transforms[0], np.eye(4))
    for a in group.transforms:
        for b in group.transforms:
            assert np.abs(group.transforms - a @ b).max(axis=(1, 2)).min() < 1e-12


def test_equivalents_compose_on_the_object_side() -> None:
    T = make_transform(rotation_z(0.3), np.array([1.0, 2, 3]))
    poses = SymmetryGroup.turns("z", 2).equivalents(T)
    np.testing.assert_allclose(poses[1], make_transform(rotation_z(0.3 + np.pi), np.array([1.0, 2, 3])), atol=1e-12)
