import numpy as np

from tests.dataset.toy import PALLET
from warehouse_sim.estimators.segmenters.segnet.keypoints import MIRRORED, face_points, pocket_faces, side_points
from warehouse_sim.geometry.pose import level_camera, make_transform, rotation_z


def test_points_of_a_side_are_named_as_one_sees_them_who_stands_before_it() -> None:
    """Seen from -y, right is +x: corners and pockets by hand."""
    pallet = PALLET
    points, known = side_points(pallet.size, pallet.pockets, "-y")
    length, width, height = pallet.size
    np.testing.assert_allclose(points[0], [-length / 2, -width / 2, height / 2])
    np.testing.assert_allclose(points[2], [length / 2, -width / 2, -height / 2])
    # The toy pallet has one pocket a side: no two centres to tell.
    assert known.tolist() == [True] * 4 + [False] * 2
    assert pocket_faces(pallet.pockets) == ["+y", "-y"]


def test_the_side_that_is_seen_is_taken_and_left_is_left_in_the_image() -> None:
    for yaw in np.linspace(-2.8, 2.8, 9):
        T_world_camera = level_camera(np.array([0.0, -4.0, 1.0]), np.pi / 2)
        T_camera_object = np.linalg.inv(T_world_camera) @ make_transform(rotation_z(yaw), np.array([0.2, 0.0, 0.1]))
        face = face_points(PALLET.size, PALLET.pockets, T_camera_object)
        assert face is not None
        points, _ = face
        u, v = points[:, 0] / points[:, 2], points[:, 1] / points[:, 2]
        assert u[0] < u[1]
        assert u[3] < u[2]
        assert v[0] < v[3]
        assert points[:4, 2].mean() < T_camera_object[2, 3]


def test_the_mirror_of_the_mirror_is_the_point_itself() -> None:
    assert [MIRRORED[MIRRORED[i]] for i in range(6)] == list(range(6))
