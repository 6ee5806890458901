import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.cartons import SKUS
from warehouse_sim.catalog.pallets import PALLETS
from warehouse_sim.geometry.mesh import TriangleMesh, merge, unit_box
from warehouse_sim.geometry.symmetry import SymmetryGroup, shape_symmetry

TRIVIAL = SymmetryGroup.trivial()


def box(x, y, z):
    return TriangleMesh(unit_box().vertices * [x, y, z], unit_box().faces)


@pytest.mark.parametrize(("size", "count"), [((0.6, 0.4, 0.3), 4), ((0.4, 0.4, 0.3), 8), ((0.4, 0.4, 0.4), 24)])
def test_a_box_has_the_turns_of_its_edges(size, count):
    group = shape_symmetry(box(*size), TRIVIAL)
    assert len(group) == count
    assert np.array_equal(group.transforms[0], np.eye(4))
    assert np.allclose(np.linalg.det(group.transforms), 1.0)


def test_what_stands_out_of_a_side_breaks_the_turns_that_move_it():
    lid = TriangleMesh(box(0.3, 0.2, 0.05).vertices + np.array([0.0, 0.0, 0.175]), unit_box().faces)
    group = shape_symmetry(merge([box(0.6, 0.4, 0.3), lid]), TRIVIAL)
    assert np.array_equal(group.transforms, SymmetryGroup.turns("z", 2).transforms)


@pytest.mark.parametrize("name", sorted(PALLETS))
def test_pallets_declare_the_symmetry_of_their_shape(name):
    model = catalog_object(name)
    assert np.array_equal(shape_symmetry(model.mesh(), TRIVIAL).transforms, model.symmetry.transforms)


@pytest.mark.parametrize("sku", sorted(SKUS))
def test_cartons_turn_by_half_whatever_is_printed_on_them(sku):
    model = catalog_object(sku)
    group = shape_symmetry(model.mesh(), model.symmetry)
    assert np.array_equal(group.transforms, SymmetryGroup.turns("z", 2).transforms)


def test_a_group_that_the_shape_adds_nothing_to_is_returned_as_it_is():
    model = catalog_object("epal1")
    assert shape_symmetry(model.mesh(), model.symmetry) is model.symmetry


def test_a_declared_turn_that_the_shape_lacks_is_believed():
    declared = SymmetryGroup.turns("z", 4)
    assert shape_symmetry(box(0.6, 0.4, 0.3), declared) is declared
