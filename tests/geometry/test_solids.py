import numpy as np
import pytest

from tests.catalog.covering import volume
from warehouse_sim.geometry.solids import (
    lathe,
    prism,
    superellipsoid,
    unit_cylinder,
    unit_tube,
)

L_SHAPE = ((0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0))
UNIT = {
    "cylinder": unit_cylinder(),
    "tube": unit_tube(0.9),
    "sack": superellipsoid(dent=0.3),
}
SOLIDS = UNIT | {
    "bottle": lathe(((0.0, 0.0), (0.4, 0.0), (0.4, 1.0), (0.1, 1.2), (0.1, 1.5), (0.0, 1.5))),
    "prism": prism(L_SHAPE, 2.0),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_every_edge_is_walked_once_each_way_and_no_face_is_flat(name: str) -> None:
    mesh = SOLIDS[name]
    edges = np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]])
    directed = {tuple(edge) for edge in edges.tolist()}
    assert len(directed) == len(edges)
    assert all((b, a) in directed for a, b in directed)
    assert mesh.face_areas().min() > 1e-8
    assert volume(mesh) > 0.0


@pytest.mark.parametrize("name", UNIT)
def test_unit_solids_fill_the_unit_cube(name: str) -> None:
    np.testing.assert_allclose(UNIT[name].vertices.min(axis=0), -0.5, atol=1e-12)
    np.testing.assert_allclose(UNIT[name].vertices.max(axis=0), 0.5, atol=1e-12)


def test_volumes_are_those_of_the_formulas() -> None:
    circle = 96 / 8 * np.sin(2 * np.pi / 96)  # area of the regular 96-gon in a circle of diameter 1
    assert volume(unit_cylinder(96)) == pytest.approx(circle)
    assert volume(unit_tube(0.8, 96)) == pytest.approx(circle * (1 - 0.64))
    assert volume(prism(L_SHAPE, 2.0)) == pytest.approx(2 * 4.0)
    assert volume(superellipsoid(2.0, 2.0, 96, 96)) == pytest.approx(np.pi / 6, rel=0.005)
    assert volume(superellipsoid(20.0, 20.0, 96, 96)) > 0.9


def test_quarter_turns_leave_a_round_solid_unchanged_without_rounding() -> None:
    points = {tuple(row) for row in unit_cylinder(32).vertices.tolist()}
    assert {(-y, x, z) for x, y, z in points} == points


def test_impossible_solids_are_rejected() -> None:
    with pytest.raises(ValueError, match="multiple of 4"):
        unit_cylinder(10)
    with pytest.raises(ValueError, match="begin and end on the axis"):
        lathe(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)))
    with pytest.raises(ValueError, match="counter-clockwise"):
        prism(L_SHAPE[::-1])
