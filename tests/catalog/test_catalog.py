import numpy as np
import pytest

from warehouse_sim.catalog import catalog_names, catalog_object
from warehouse_sim.catalog.materials import materials
from warehouse_sim.catalog.textures import TEXTURES
from warehouse_sim.errors import UnknownNameError
from warehouse_sim.geometry.mesh import unit_box
from warehouse_sim.geometry.pose import transform_points


def test_an_object_fills_its_declared_size_around_its_origin() -> None:
    for name in catalog_names():
        model = catalog_object(name)
        vertices = model.mesh().vertices
        np.testing.assert_allclose(vertices.min(axis=0), -model.size / 2, atol=1e-9, err_msg=name)
        np.testing.assert_allclose(vertices.max(axis=0), model.size / 2, atol=1e-9, err_msg=name)


def test_faces_look_outwards_and_materials_exist() -> None:
    for name in catalog_names():
        model = catalog_object(name)
        for part in model.parts:
            assert part.material in materials(), name
            placed = part.placed()
            a, b, c = np.moveaxis(placed.vertices[placed.faces], 1, 0)
            volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
            assert volume == pytest.approx(np.prod(part.scale)) if part.mesh is unit_box() else volume > 0.0, name


def test_every_part_is_watertight() -> None:
    for name in catalog_names():
        for mesh in {part.mesh for part in catalog_object(name).parts}:
            edges = np.concatenate([mesh.faces[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]).astype(np.int64)
            there, back = (edges[:, k] * len(mesh.vertices) + edges[:, 1 - k] for k in (0, 1))
            assert len(np.unique(there)) == len(there), name  # no edge is run through twice the same way
            np.testing.assert_array_equal(np.sort(there), np.sort(back), err_msg=name)
            assert mesh.face_areas().min() > 0.0, name


def test_collision_boxes_stay_inside_the_object() -> None:
    for name in catalog_names():
        model = catalog_object(name)
        corners = np.concatenate([np.zeros((1, 3)), *(box.corners() for box in model.collision)])
        assert np.all(np.abs(corners) <= model.size / 2 + 1e-9), name


def test_declared_symmetries_leave_the_shape_unchanged() -> None:
    for name in catalog_names():
        model = catalog_object(name)
        if len(model.symmetry) == 1:
            continue
        vertices = model.mesh().vertices
        points = {tuple(row) for row in np.round(vertices, 9) + 0.0}
        for transform in model.symmetry.transforms[1:]:
            assert {tuple(row) for row in np.round(transform_points(transform, vertices), 9) + 0.0} == points, name


def test_one_number_stands_for_one_geometry() -> None:
    shapes: dict[int, np.ndarray] = {}
    for name in catalog_names():
        model = catalog_object(name)
        vertices = model.mesh().vertices
        assert model.obj_id >= 1
        np.testing.assert_array_equal(shapes.setdefault(model.obj_id, vertices), vertices)
    assert len({(shape.shape, shape.tobytes()) for shape in shapes.values()}) == len(shapes)


def test_names_are_the_models_own_and_builders_are_shared() -> None:
    for name in catalog_names():
        assert catalog_object(name).name == name
        assert catalog_object(name) is catalog_object(name)


def test_an_unknown_object_lists_the_known_ones() -> None:
    with pytest.raises(UnknownNameError, match="did you mean"):
        catalog_object("palet")


def test_materials_are_physical() -> None:
    for name in materials():
        material = materials()[name]
        assert material.name == name
        assert all(0.0 <= channel <= 1.0 for channel in material.base_color), name
        assert 0.0 <= material.roughness <= 1.0, name
        assert 0.0 <= material.metallic <= 1.0, name
        assert 0.0 < material.remission <= 2.0, name
        assert material.texture is None or material.texture in TEXTURES, name


def test_remission_follows_the_cited_table() -> None:
    remission = {name: material.remission for name, material in materials().items()}
    assert remission["pallet_wood"] == 0.4  # untreated soiled fir
    assert remission["label_paper"] == 0.8  # white paper
    assert remission["print_dark"] < remission["kraft"] < remission["pallet_wood"] < remission["galvanised"]
