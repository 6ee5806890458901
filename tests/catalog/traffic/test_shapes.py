import numpy as np
import pytest

from tests.catalog.covering import volume
from warehouse_sim.catalog.parts import box_part, solid_box
from warehouse_sim.catalog.traffic.shapes import assembled, limb_box, rod, side_profile, tube


def test_a_straight_tube_is_a_prism_of_its_sections() -> None:
    mesh = tube([(0, 0, 0), (0, 0, 1), (0, 0, 2)], [(0.3, 0.5)] * 3, sides=16)
    area = 16 / 2 * np.sin(2 * np.pi / 16) * 0.3 * 0.5
    assert volume(mesh) == pytest.approx(2 * area)
    np.testing.assert_allclose(mesh.vertices.max(axis=0), [0.3, 0.5, 2.0])


@pytest.mark.parametrize("end", [(1.0, 0.0, 0.0), (0.0, -2.0, 0.0), (0.0, 0.0, 0.5), (0.3, 0.4, -0.5)])
def test_a_rod_runs_from_end_to_end(end: tuple[float, float, float]) -> None:
    mesh, axis = rod((0, 0, 0), end, 0.1), np.array(end)
    length = np.linalg.norm(axis)
    along = mesh.vertices @ axis / length
    assert (along.min(), along.max()) == (pytest.approx(0.0, abs=1e-12), pytest.approx(length))
    away = np.linalg.norm(mesh.vertices - np.outer(along, axis / length), axis=1)
    assert away.max() == pytest.approx(0.1)
    assert volume(mesh) > 0.0


def test_a_side_profile_keeps_x_and_z() -> None:
    part = side_profile(((1.0, 2.0), (3.0, 2.0), (3.0, 5.0)), 0.4, "rubber", y=1.0).placed()
    np.testing.assert_allclose(part.vertices.min(axis=0), [1.0, 0.8, 2.0])
    np.testing.assert_allclose(part.vertices.max(axis=0), [3.0, 1.2, 5.0])
    assert volume(part) == pytest.approx(3.0 * 0.4)


def test_a_limb_box_follows_its_limb() -> None:
    box = limb_box((0.0, 0.0, 0.0), (1.0, 0.0, 1.0), 0.1)
    ends = box.T_parent_box @ np.array([[0, 0, -np.sqrt(0.5), 1], [0, 0, np.sqrt(0.5), 1]]).T
    np.testing.assert_allclose(ends[:3].T, [[0, 0, 0], [1, 0, 1]], atol=1e-12)
    assert np.linalg.det(box.T_parent_box[:3, :3]) == pytest.approx(1.0)


def test_assembling_centres_fuses_and_cuts_boxes_back() -> None:
    parts = [box_part((1, 1, 1), (0.5, 0, 0.5), "rubber"), box_part((1, 1, 1), (1.5, 0, 0.5), "rubber")]
    boxes = [solid_box((3.0, 1.0, 1.0), (1.0, 0.0, 0.5)), limb_box((0.2, 0.0, 0.2), (1.9, 0.0, 0.9), 0.3)]
    model = assembled("thing", "guard", 199, parts, boxes, 1.0)
    np.testing.assert_allclose(model.size, [2.0, 1.0, 1.0])
    assert len(model.parts) == 1
    np.testing.assert_allclose(model.mesh().vertices.mean(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose(model.collision[0].size, [2.0, 1.0, 1.0])
    for box in model.collision:
        assert np.all(np.abs(box.corners()) <= model.size / 2 + 1e-12)
