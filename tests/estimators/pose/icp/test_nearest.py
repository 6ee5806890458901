import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from tests.dataset.toy import PALLET
from warehouse_sim.estimators.pose.icp.nearest import NearestByCell, SurfaceCells, VisibleSurfaces
from warehouse_sim.estimators.pose.icp.surface import CadSurface, Triangles, build_surface, inside, seeded_surface
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.mesh import TriangleMesh, unit_box
from warehouse_sim.geometry.pose import make_transform, transform_points

SURFACE = build_surface(PALLET.mesh(), 6000, np.random.default_rng(0))
BOX = build_surface(unit_box(), 4000, np.random.default_rng(0))


def seen(surface: CadSurface, eye: list[float], anisotropy: float) -> VisibleSurfaces:
    return VisibleSurfaces([surface], np.array([eye]), np.array([anisotropy]))


def test_distance_before_a_face_is_signed_and_along_its_normal() -> None:
    distance, direction = seen(BOX, [5.0, 0, 0], 1.0).nearest(np.array([[[0.7, 0.1, -0.2], [0.45, 0.3, 0.1]]]))
    np.testing.assert_allclose(distance[0], [0.2, -0.05], atol=1e-12)
    np.testing.assert_allclose(direction[0], [[1, 0, 0]] * 2, atol=1e-12)


def test_distance_beside_a_face_grows_away_from_its_edge() -> None:
    distance, direction = seen(BOX, [5.0, 0, 0], 1.0).nearest(np.array([[[0.5, 0.8, 0.0]]]))
    np.testing.assert_allclose(distance[0], [0.3], atol=1e-12)
    np.testing.assert_allclose(direction[0], [[0, 1, 0]], atol=1e-12)


@pytest.mark.parametrize("anisotropy", [1.0, 0.2])
def test_gradient_of_the_scaled_distance(anisotropy: float) -> None:
    visible = seen(SURFACE, [4.0, 1.5, 0.8], anisotropy)
    rng = np.random.default_rng(3)
    points = SURFACE.points[rng.integers(0, len(SURFACE.points), 200)] + rng.normal(0, 0.02, (200, 3))
    distance, gradient = visible.nearest(points[None])
    step = 1e-6
    moved = [visible.nearest(points[None] + step * axis)[0][0] for axis in np.eye(3)]
    numeric = np.stack([(there - distance[0]) / step for there in moved], axis=1)
    error = np.linalg.norm(numeric - gradient[0], axis=1)
    # A few points lie where the nearest triangle changes.
    assert np.mean(error < 1e-3) > 0.95


def test_anisotropy_makes_errors_along_the_view_cheap() -> None:
    distance, _ = seen(BOX, [6.0, 0.0, 0.0], 0.1).nearest(np.array([[[0.7, 0.0, 0.0], [0.5, 0.7, 0.0]]]))
    np.testing.assert_allclose(distance[0], [0.02, 0.2], atol=1e-12)


def test_objects_of_a_batch_see_their_own_surface_only() -> None:
    eyes, anisotropy = np.array([[5.0, 0, 0], [4.0, 1.5, 0.8]]), np.array([1.0, 0.3])
    points = np.random.default_rng(4).uniform(-1, 1, (2, 50, 3))
    distance, direction = VisibleSurfaces([BOX, SURFACE], eyes, anisotropy).nearest(points)
    for i, surface in enumerate((BOX, SURFACE)):
        alone = VisibleSurfaces([surface], eyes[i : i + 1], anisotropy[i : i + 1]).nearest(points[i : i + 1])
        np.testing.assert_allclose(distance[i], alone[0][0], atol=1e-9)
        np.testing.assert_allclose(direction[i], alone[1][0], atol=1e-6)


def test_from_inside_an_object_there_is_still_an_answer() -> None:
    distance, _ = seen(BOX, [0.01, 0.02, 0.0], 0.5).nearest(np.zeros((1, 3, 3)))
    assert np.isfinite(distance).all()


SIZE = np.array([1.2, 0.8, 0.3])
EYE = np.array([2.0, 1.5, 1.0])
"""A camera that sees the three sides in the positive directions."""


def cells() -> SurfaceCells:
    mesh = TriangleMesh(box_corners(SIZE), unit_box().faces)
    return SurfaceCells(build_surface(mesh, 20_000, np.random.default_rng(0)))


def test_the_nearest_sample_is_at_most_a_cell_farther_than_that_of_a_slow_search() -> None:
    table = cells()
    surface = table.surface
    points = np.random.default_rng(1).uniform(-0.7, 0.7, (1, 500, 3)) * SIZE
    octant = table.octants(EYE[None])
    facing = np.flatnonzero((surface.normals @ np.ones(3) > 0)[surface.faces])
    found = table.samples_near(points, octant)[0]
    assert set(found.tolist()) <= set(facing.tolist())
    slow = np.linalg.norm(points[0][:, None] - surface.points[facing], axis=2).min(axis=1)
    away = np.linalg.norm(points[0] - surface.points[found], axis=1)
    # Half a diagonal of the point's cell and half one of the sample's.
    assert (away - slow).max() <= 2.0 * np.sqrt(3.0) * table.step


def test_over_a_face_the_distance_is_that_to_its_plane_and_behind_it_is_negative() -> None:
    table = cells()
    points = np.array([[[0.1, 0.1, 0.2], [0.1, 0.1, 0.13], [0.65, 0.0, 0.0], [0.0, 0.44, 0.05]]])
    distance, direction = NearestByCell([table], EYE[None]).nearest(points)
    np.testing.assert_allclose(distance[0], [0.05, -0.02, 0.05, 0.04], atol=1e-9)
    np.testing.assert_allclose(direction[0], np.eye(3)[[2, 2, 0, 1]], atol=1e-9)


def test_beside_all_faces_the_distance_points_away_from_the_nearest_edge() -> None:
    table = cells()
    distance, direction = NearestByCell([table], EYE[None]).nearest(np.array([[[0.8, 0.0, 0.35]]]))
    assert distance[0, 0] == pytest.approx(np.hypot(0.2, 0.2), abs=2.0 * table.step)
    assert direction[0, 0] @ np.array([1.0, 0.0, 1.0]) / np.sqrt(2.0) > 0.98


def test_rows_of_one_object_and_of_several_are_the_same_alone_and_together() -> None:
    first, second = cells(), cells()
    eyes = np.array([EYE, -EYE, EYE * [1, -1, 1]])
    points = np.random.default_rng(2).uniform(-0.6, 0.6, (3, 40, 3)) * SIZE
    together = NearestByCell([first, first, second], eyes).nearest(points)
    for row, table in enumerate((first, first, second)):
        alone = NearestByCell([table], eyes[row : row + 1]).nearest(points[row : row + 1])
        np.testing.assert_array_equal(alone[0][0], together[0][row])
        np.testing.assert_array_equal(alone[1][0], together[1][row])


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
    normals = trimesh.triangles.normals(corners)[0]
    offset, height = Triangles(corners, normals).offset(points, np.arange(400))
    np.testing.assert_allclose(points - offset, expected, atol=1e-9)
    np.testing.assert_allclose(height, ((points - corners[:, 0]) * normals).sum(axis=1), atol=1e-12)


def test_a_cad_model_is_sampled_once_whoever_reads_it() -> None:
    box, again = unit_box(), TriangleMesh(unit_box().vertices.copy(), unit_box().faces.copy())
    surface = seeded_surface(box, 3, 7)
    assert seeded_surface(again, 3, 7) is surface
    np.testing.assert_array_equal(surface.points, build_surface(box, 20_000, np.random.default_rng([7, 3])).points)
    larger = TriangleMesh(2.0 * box.vertices, box.faces)
    assert seeded_surface(larger, 3, 7).size == pytest.approx(2.0 * surface.size, rel=0.01)
    assert not np.array_equal(seeded_surface(box, 4, 7).points, surface.points)
