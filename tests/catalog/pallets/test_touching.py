import numpy as np
import pytest

from tests.catalog.pallets.touching import is_closed, reaches_into
from warehouse_sim.geometry.mesh import TriangleMesh, unit_box
from warehouse_sim.geometry.pose import make_transform, rotation_z


@pytest.mark.parametrize(("x", "expected"), [(0.0, True), (0.99, True), (1.0, False), (1.5, False)])
def test_two_unit_boxes_reach_into_each_other_up_to_contact(x: float, expected: bool) -> None:
    # The box is a little larger than the mesh, so that a triangle crosses it even where both share a centre.
    assert reaches_into(unit_box(), make_transform(translation=np.array([x, 0.1, 0.1])), np.ones(3)) is expected


def test_an_edge_between_the_axes_is_seen() -> None:
    corner = 0.5 + np.sqrt(0.5)
    for gap, expected in ((-0.01, True), (0.01, False)):
        T = make_transform(rotation_z(np.pi / 4), np.array([corner + gap, 0.0, 0.0]))
        assert reaches_into(unit_box(), T, np.ones(3)) is expected


def test_a_box_without_a_face_is_not_closed() -> None:
    assert is_closed(unit_box())
    assert not is_closed(TriangleMesh(unit_box().vertices, unit_box().faces[:-1]))
