import numpy as np
import pytest

from tests.catalog.covering import shipped, volume
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.cartons import HEAVY_SKUS, SKUS
from warehouse_sim.catalog.loads.drums import DRUMS, drum
from warehouse_sim.catalog.loads.open_cartons import OPEN_CARTONS
from warehouse_sim.catalog.loads.sacks import SACK_SHAPES, SACKS, sack, shapes_of
from warehouse_sim.catalog.loads.securing import CORNER_POSTS, SLIP_SHEETS, WRAPS
from warehouse_sim.catalog.loads.strength import bears
from warehouse_sim.catalog.loads.totes import TOTES, tote
from warehouse_sim.catalog.shipped import CARRIERS

CLASSES = {
    "carton": SKUS,
    "tote": TOTES,
    "drum": DRUMS,
    "sack": SACKS,
    "slip_sheet": SLIP_SHEETS,
    "corner_post": CORNER_POSTS,
    "wrap": WRAPS,
}

LOADS = shipped("loads")
_FURTHER = {*CARRIERS, *SACK_SHAPES, *HEAVY_SKUS, *OPEN_CARTONS}


def test_every_load_has_the_class_of_its_list() -> None:
    assert {name for names in CLASSES.values() for name in names} == set(LOADS) - _FURTHER
    for class_name, names in CLASSES.items():
        assert {catalog_object(name).class_name for name in names} == {class_name}


def test_numbers_are_those_reserved_for_loads_and_one_a_geometry() -> None:
    numbers = {name: catalog_object(name).obj_id for name in LOADS if name not in _FURTHER}
    assert set(numbers.values()) <= set(range(11, 61))
    families = {name: tuple(catalog_object(name).size) for name in LOADS}
    assert len({(number, families[name]) for name, number in numbers.items()}) == len(set(numbers.values()))


def test_goods_stand_on_their_whole_box() -> None:
    for name in [*SKUS, *HEAVY_SKUS, *TOTES, *SACKS]:
        model = catalog_object(name)
        base, *others = model.collision
        np.testing.assert_array_equal(base.size[:2], model.size[:2], err_msg=name)
        assert base.corners()[:, 2].min() == -model.size[2] / 2, name
        is_open = name in TOTES and "lid" not in name
        assert bool(others) == is_open, name
        if not is_open:
            np.testing.assert_array_equal(base.size, model.size, err_msg=name)


def test_a_load_is_few_parts_and_not_too_many_triangles() -> None:
    for name in set(LOADS) - _FURTHER:
        model = catalog_object(name)
        assert len(model.parts) <= 7, name
        assert len(model.mesh().faces) <= 3500, name


def blocked(name: str, start: np.ndarray, end: np.ndarray) -> bool:
    """Return whether a line from ``start`` to ``end`` meets the tote (Moeller and Trumbore 1997)."""
    mesh = tote(name).mesh()
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    way = end - start
    p = np.cross(way, c - a)
    det = np.einsum("ij,ij->i", b - a, p)
    det = np.where(np.abs(det) < 1e-12, np.nan, det)  # lines along a face do not count
    t = start - a
    u = np.einsum("ij,ij->i", t, p) / det
    q = np.cross(t, b - a)
    v = q @ way / det
    at = np.einsum("ij,ij->i", c - a, q) / det
    return bool(np.any((u >= 0) & (v >= 0) & (u + v <= 1) & (at >= 0) & (at <= 1)))


@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("tote_600x400x280_grey", (0.594, 0.396, 0.280)),
        ("tote_600x400x147_blue", (0.594, 0.396, 0.1475)),
        ("tote_400x300x280_red", (0.396, 0.297, 0.280)),
        ("tote_600x400x280_lid_grey", (0.594, 0.396, 0.280)),
    ],
)
def test_sizes_are_those_of_vda_4500(name: str, size: tuple[float, float, float]) -> None:
    np.testing.assert_array_equal(tote(name).size, size)


def test_a_tote_can_be_carried_by_hand() -> None:
    for name in TOTES:
        assert 3.0 < tote(name).mass <= 15.0, name


def test_one_sees_into_an_open_tote_and_not_into_a_closed_one() -> None:
    above, inside = np.array([0.1, 0.1, 0.3]), np.array([0.1, 0.1, 0.125])
    assert not blocked("tote_600x400x280_grey", above, inside)
    assert blocked("tote_600x400x280_lid_grey", above, inside)
    assert blocked("tote_600x400x280_grey", above, np.array([0.1, 0.1, -0.139]))  # goods and floor


def test_grip_holes_are_holes() -> None:
    height = 0.14 - 0.022 - 0.02
    assert not blocked("tote_600x400x280_grey", np.array([0.4, 0.0, height]), np.array([0.27, 0.0, height]))
    assert blocked("tote_600x400x280_grey", np.array([0.4, 0.1, height]), np.array([0.27, 0.1, height]))


@pytest.mark.parametrize("name", DRUMS)
def test_collision_boxes_make_an_octagon_inside_the_drum(name: str) -> None:
    model = drum(name)
    corners = np.concatenate([box.corners() for box in model.collision])
    radius = np.linalg.norm(corners[:, :2], axis=1)
    np.testing.assert_allclose(radius, model.size[0] / 2)
    assert len(np.unique(np.round(corners[:, :2], 6), axis=0)) == 8
    np.testing.assert_allclose(np.abs(corners[:, 2]), model.size[2] / 2)


def test_drums_weigh_what_they_hold() -> None:
    steel, plastic, small = (drum(f"drum_{kind}_blue") for kind in ("steel_216", "plastic_220", "plastic_60"))
    assert steel.mass == pytest.approx(18.0 + 0.2165 * 900)
    assert plastic.mass == pytest.approx(9.5 + 220)
    assert small.mass < 60.0


@pytest.mark.parametrize(("name", "litres"), [("drum_steel_216_blue", 216.5), ("drum_plastic_220_blue", 220.0)])
def test_the_body_holds_what_its_name_says(name: str, litres: float) -> None:
    assert 1000 * volume(drum(name).parts[0].placed()) == pytest.approx(litres, rel=0.06)


def test_the_steel_drum_has_two_hoops_two_plugs_and_a_label_on_its_side() -> None:
    model = drum("drum_steel_216_blue")
    body = model.parts[0].placed().vertices
    radius = np.linalg.norm(body[:, :2], axis=1)
    hoops = np.unique(np.round(body[radius > 0.2920, 2], 6))
    assert len(hoops) == 4  # lower and upper edge of each
    plugs = [part for part in model.parts if part.material == "galvanised"]
    assert [np.sign(part.T_object_part[0, 3]) for part in plugs] == [1.0, -1.0]
    assert all(part.placed().vertices[:, 2].max() < model.size[2] / 2 for part in plugs)
    label = next(part for part in model.parts if part.material == "label_paper").placed().vertices
    assert label[:, 1].min() > 0.2
    assert np.linalg.norm(label[:, :2], axis=1).max() == pytest.approx(0.2868)


def _held(name: str) -> float:
    return volume(sack(name).parts[0].placed())


@pytest.mark.parametrize("name", SACKS)
def test_a_sack_is_a_cushion_and_not_a_box(name: str) -> None:
    assert 0.75 < _held(name) / np.prod(sack(name).size) < 0.95


def test_the_goods_have_the_density_of_cement_and_granules() -> None:
    assert 1000.0 < 25.0 / _held("sack_paper_600x400x110") < 1400.0
    assert 550.0 < 20.0 / _held("sack_woven_590x390x140") < 800.0


@pytest.mark.parametrize("name", SACKS)
def test_the_print_follows_the_sack_everywhere(name: str) -> None:
    body, field = (part.placed().vertices for part in sack(name).parts)
    distance = np.linalg.norm(field[:, None] - body[None], axis=2).min(axis=1)
    on_skin = np.abs(field[:, 1:]).max(axis=1) > 0.02  # not the middle of an end cap, which is inside
    assert distance[on_skin].max() < 0.003


@pytest.mark.parametrize("name", SACKS)
def test_the_shapes_of_an_article_differ_and_are_as_high_and_full(name: str) -> None:
    names = shapes_of(name)
    models = [sack(one) for one in names]
    assert len(names) == 6
    assert len({model.obj_id for model in models}) == 6
    assert {float(model.size[2]) for model in models} == {float(models[0].size[2])}
    for one, model in zip(names, models, strict=True):
        assert np.all(model.size <= models[0].size)
        vertices = model.mesh().vertices
        np.testing.assert_allclose(vertices.max(axis=0) - vertices.min(axis=0), model.size, atol=1e-6)
        assert 0.65 < _held(one) / np.prod(model.size) < 0.95
    points = [model.parts[0].placed().vertices / model.size for model in models]
    assert min(np.abs(a - b).max() for i, a in enumerate(points) for b in points[:i]) > 0.03


@pytest.mark.parametrize("name", CARRIERS)
def test_a_carrier_stands_on_its_boxes_and_is_few_parts(name: str) -> None:
    model = catalog_object(name)
    corners = np.concatenate([box.corners() for box in model.collision])
    assert corners[:, 2].min() == pytest.approx(-model.size[2] / 2)
    assert len(model.mesh().faces) <= 7000
    assert len(model.parts) <= 12


def test_numbers_are_those_reserved_for_carriers_and_one_a_geometry() -> None:
    numbers = [catalog_object(name).obj_id for name in CARRIERS]
    assert len(set(numbers)) == len(CARRIERS)
    assert set(numbers) <= set(range(301, 400))


def test_standard_sizes_and_masses() -> None:
    assert catalog_object("gitterbox_empty").size.tolist() == [1.240, 0.835, 0.970]
    assert catalog_object("gitterbox_empty").mass == 70.0
    for name in CARRIERS:
        assert 30.0 < catalog_object(name).mass <= 1570.0
    assert catalog_object("ibc_1000").size[2] + catalog_object("epal3").size[2] == pytest.approx(1.16)


def test_boxes_of_steel_bear_stacks_and_bags_nothing() -> None:
    assert bears(catalog_object("gitterbox_cartons")) == 4400.0
    assert bears(catalog_object("ibc_1000")) > 3 * catalog_object("ibc_1000").mass
    assert bears(catalog_object("big_bag_1000x950x1200")) == 0.0
    assert bears(catalog_object("roll_container_full")) == 0.0
