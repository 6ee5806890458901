import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from tests.dataset.toy import PALLET
from warehouse_sim.estimators.pose.icp.surface import build_surface, closest_points, inside
from warehouse_sim.geometry.mesh import TriangleMesh, unit_box
from warehouse_sim.geometry.pose import make_transform, transform_points

SURFACE = build_surface(PALLET.mesh(), 6000, np.random.default_rng(0))


def test_faces_covered_by_another_part_are_gone() -> None:
    # The skids carry the deck at z = 0.032; their tops and the deck above them touch.
    covered = (np.abs(SURFACE.points[:, 2] - 0.032) < 1e-9) & (np.abs(np.abs(SURFACE.points[:, 0]) - 0.5) < 0.1)
    assert not covered.any()
    open_deck = (np.abs(SURFACE.points[:, 2] - 0.032) < 1e-9) & (np.abs(SURFACE.points[:, 0]) < 0.4)
    assert open_deck.sum() > 300


def test_samples_lie_on_their_triangles() -> None:
    offset = SURFACE.points - SURFACE.corners[SURFACE.faces, 0]
    np.testing.assert_allclose((offset * SURFACE.normals[SURFACE.faces]).sum(axis=1), 0.0, atol=1e-12)


def test_inside_agrees_with_the_boxes() -> None:
    rng = np.random.default_rng(1)
    points = rng.uniform(-0.8, 0.8, (500, 3)) * [1, 1, 0.15]
    mesh = PALLET.mesh()
    expected = np.zeros(len(points), dtype=bool)
    for part in PALLET.parts:
        local = points - part.T_object_part[:3, 3]
        expected |= (np.abs(local) < part.scale / 2).all(axis=1)
    assert 20 < expected.sum() < 480
    np.testing.assert_array_equal(inside(mesh.vertices[mesh.faces], points), expected)


def winding_number(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """By solid angles, after Van Oosterom and Strackee, IEEE TBME 30(2), 1983."""
    a, b, c = np.moveaxis(corners[None] - points[:, None, None], 2, 0)
    length_a, length_b, length_c = (np.linalg.norm(edge, axis=-1) for edge in (a, b, c))
    volume = (a * np.cross(b, c)).sum(axis=-1)
    dots = length_a * length_b * length_c
    dots += (a * b).sum(-1) * length_c + (b * c).sum(-1) * length_a + (c * a).sum(-1) * length_b
    return np.arctan2(volume, dots).sum(axis=1) / (2.0 * np.pi)


def test_inside_agrees_with_the_winding_number_of_parts_that_overlap() -> None:
    torus, ball = trimesh.creation.torus(0.5, 0.2, 24, 12), trimesh.creation.icosphere(2, 0.4)
    corners = np.concatenate([torus.triangles, ball.triangles])
    points = np.random.default_rng(2).uniform(-0.8, 0.8, (600, 3)) * [1, 1, 0.4]
    expected = winding_number(corners, points) > 0.5
    assert 50 < expected.sum() < 550
    np.testing.assert_array_equal(inside(corners, points), expected)


def test_a_hole_across_one_direction_does_no_harm() -> None:
    box = unit_box()
    turned = transform_points(make_transform(Rotation.from_rotvec([0.2, 0.1, 0.4]).as_matrix()), box.vertices)
    corners = TriangleMesh(turned, box.faces).vertices[box.faces][2:]
    votes = inside(corners, np.random.default_rng(3).uniform(-0.3, 0.3, (200, 3)))
    assert votes.mean() > 0.7


def test_closest_points_are_those_of_trimesh() -> None:
    rng = np.random.default_rng(2)
    corners, points = rng.normal(size=(400, 3, 3)), rng.normal(size=(400, 3)) * 2
    expected = trimesh.triangles.closest_point(corners, points)
    np.testing.assert_allclose(closest_points(points, corners), expected, atol=1e-9)
