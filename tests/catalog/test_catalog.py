import numpy as np
import pytest

from tests.catalog.covering import bare_distances, shipped
from warehouse_sim.catalog import catalog_names, catalog_object
from warehouse_sim.catalog.materials import materials, smooth_materials
from warehouse_sim.catalog.parts import box_part, fused, solid_part
from warehouse_sim.catalog.shipped import CLUTTER
from warehouse_sim.catalog.textures import TEXTURES
from warehouse_sim.catalog.traffic.people import PEOPLE, WORKERS_BY_NAME
from warehouse_sim.catalog.traffic.working import WORKING
from warehouse_sim.errors import UnknownNameError
from warehouse_sim.geometry.mesh import unit_box
from warehouse_sim.geometry.pose import rotation_z, transform_points
from warehouse_sim.geometry.solids import unit_cylinder


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


COVERED = {
    "building": (0.030 + 1e-9, [name for name in shipped("building") if catalog_object(name).collision]),
    "racks": (0.009, shipped("racks")),
    "obstacles": (0.003, ("cone_500", "cone_750", "bollard", "floor_sign")),
    "people": (0.025, PEOPLE),
    "workers": (0.040, WORKERS_BY_NAME),
    "trucks at work": (0.040, WORKING),
}
"""How far (m) the mesh of an object of each kind stands out of its collision boxes at most."""


@pytest.mark.parametrize("kind", COVERED)
def test_collision_boxes_cover_the_mesh(kind: str) -> None:
    most, names = COVERED[kind]
    for name in names:
        assert bare_distances(catalog_object(name)).max() <= most, name


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


# Clutter stands on its own feet, and its boxes are where it is. Its shape is checked with the whole catalog's.


@pytest.mark.parametrize("name", CLUTTER)
def test_it_stands_on_more_than_a_point_under_its_middle(name: str) -> None:
    model = catalog_object(name)
    assert model.class_name == "clutter"
    assert 900 <= model.obj_id <= 999
    assert 0.1 < model.mass < 40.0
    assert 0.1 < model.size.max() < 1.6
    vertices = model.mesh().vertices
    feet = vertices[vertices[:, 2] < -model.size[2] / 2 + 0.012][:, :2]
    assert (feet.min(axis=0) < 0.05).all()
    assert (feet.max(axis=0) > -0.05).all()
    assert np.ptp(feet, axis=0).min() > 0.05


@pytest.mark.parametrize("name", CLUTTER)
def test_boxes_cover_what_others_could_run_into(name: str) -> None:
    assert np.percentile(bare_distances(catalog_object(name)), 95) < 0.06


LUMINANCE = (0.2126, 0.7152, 0.0722)
CITED = {
    "concrete": (0.2, 0.3),  # untreated
    "pallet_wood": (0.3, 0.6),  # light wood
    "pallet_wood_new": (0.3, 0.6),
    "pallet_wood_dark": (0.1, 0.15),  # dark wood
    "label_paper": (0.7, 0.8),  # white
    "epoxy_grey": (0.15, 0.3),  # mid-grey
    "rubber": (0.0, 0.1),  # black
}


def luminance(name: str) -> float:
    return sum(weight * channel for weight, channel in zip(LUMINANCE, materials()[name].base_color, strict=True))


@pytest.mark.parametrize("name", CITED)
def test_albedo_keeps_to_the_cited_reflectance(name: str) -> None:
    low, high = CITED[name]
    assert low - 0.005 <= luminance(name) <= high + 0.005


def test_only_film_is_translucent() -> None:
    film = {name for name, material in materials().items() if material.opacity < 1.0}
    assert "stretch_film" in film
    on_floors = {"tyre_faint", "tyre_dark", "floor_oil", "floor_repair", "floor_water"}
    on_floors |= {"floor_dust", "floor_board", "floor_film", "floor_splinter", "floor_strap"}
    assert all(materials()[name].texture == "film" for name in film - on_floors)
    assert all(materials()[name].opacity > 0.05 for name in film)


def test_plain_sheet_and_moulded_parts_have_the_texture_of_what_they_are() -> None:
    expected = {
        "pallet_wood": "wood",
        "kraft": "liner",
        "concrete": "slab",
        "rack_blue": "enamel",
        "blockwork": "blockwork",
    }
    expected |= {"galvanised": "galvanised", "rubber": "rubber", "epoxy_grey": "coat", "wall_paint": "precast"}
    expected |= {"plastic_grey": "plastic_worn"}
    assert {name: materials()[name].texture for name in expected} == expected
    smooth = {
        "kraft": "kraft",
        "concrete": "concrete",
        "rack_blue": "steel",
        "plastic_grey": "plastic",
        "epoxy_grey": "epoxy",
    }
    assert {name: smooth_materials()[name].texture for name in smooth} == smooth


def test_fusing_keeps_every_triangle_in_place_with_one_part_a_material() -> None:
    parts = [
        box_part((1.0, 2.0, 3.0), (4.0, 5.0, 6.0), "rubber"),
        solid_part(unit_cylinder(8), (1.0, 1.0, 2.0), (0.0, 1.0, 0.0), "chrome", rotation_z(0.3)),
        box_part((1.0, 1.0, 1.0), (0.0, 0.0, 0.0), "rubber", rotation_z(0.5)),
    ]
    whole = fused(parts)
    assert [part.material for part in whole] == ["rubber", "chrome"]
    for part in whole:
        pieces = [piece.placed() for piece in parts if piece.material == part.material]
        expected = np.concatenate([piece.vertices[piece.faces] for piece in pieces])
        np.testing.assert_array_equal(part.placed().vertices[part.mesh.faces], expected)
