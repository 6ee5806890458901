import numpy as np
import pytest

from tests.catalog.covering import bare_distances, filled_fraction, volume
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.materials import materials
from warehouse_sim.catalog.parts import box_part, solid_box
from warehouse_sim.catalog.shipped import FINE_STANDING, STANDING
from warehouse_sim.catalog.traffic.obstacles import CONES, FINE_CONES, WRAPS
from warehouse_sim.catalog.traffic.people import WORKERS, WORKERS_BY_NAME
from warehouse_sim.catalog.traffic.poses import ON_TRUCKS
from warehouse_sim.catalog.traffic.shapes import assembled, limb_box, rod, side_profile, tube
from warehouse_sim.catalog.traffic.truck_pieces import FORK_LENGTH, FORK_SPREAD, FORK_THICKNESS, FORK_WIDTH
from warehouse_sim.catalog.traffic.trucks import JACK_FORK, JACK_LOWERED, JACK_SPREAD
from warehouse_sim.catalog.traffic.working import WORKING, truck_frame

SIZES = {
    "cone_500": ("cone", (0.29, 0.29, 0.50)),
    "cone_750": ("cone", (0.39, 0.39, 0.75)),
    "bollard": ("bollard", (0.25, 0.25, 1.2)),
    "floor_sign": ("sign", (0.302, 0.29, 0.585)),
}


@pytest.mark.parametrize("name", SIZES)
def test_outer_size_and_class(name: str) -> None:
    model, (class_name, size) = catalog_object(name), SIZES[name]
    assert model.class_name == class_name
    np.testing.assert_allclose(model.size, size, atol=0.001)
    assert model.mass > 1.0


@pytest.mark.parametrize("name", CONES)
def test_a_cone_tapers_and_has_two_reflective_bands(name: str) -> None:
    model = catalog_object(name)
    parts = {part.material: part.placed().vertices for part in model.parts}
    heights = np.unique(np.round(parts["reflective"][:, 2] + model.size[2] / 2, 6))
    np.testing.assert_allclose(heights / model.size[2], [0.38, 0.55, 0.70, 0.82])
    orange = parts["cone_orange"]
    radius = np.linalg.norm(orange[:, :2], axis=1)
    assert radius[orange[:, 2] > 0.45 * model.size[2]].max() < 0.25 * radius.max()


@pytest.mark.parametrize("name", WRAPS)
def test_wrap_is_translucent_and_hangs_from_its_top(name: str) -> None:
    model = catalog_object(name)
    assert model.class_name == "wrap"
    assert model.collision == ()
    assert {materials()[part.material].opacity for part in model.parts} == {materials()["stretch_film"].opacity}
    assert materials()["stretch_film"].opacity < 1.0
    assert model.size[2] == pytest.approx(WRAPS[name][1], abs=0.01)
    vertices = model.mesh().vertices
    upper, lower = vertices[vertices[:, 2] > 0.0], vertices[vertices[:, 2] < -0.3 * model.size[2]]
    assert np.ptp(lower[:, 1]) < np.ptp(upper[:, 1])


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


TRUCKS = ("forklift", "reach_truck", "pallet_jack")


@pytest.mark.parametrize(
    ("name", "class_name", "size"),
    [
        ("forklift", "forklift", (3.14, 1.09, 2.15)),
        ("reach_truck", "forklift", (2.45, 1.27, 2.80)),
        ("pallet_jack", "pallet_jack", (1.54, 0.54, 1.235)),
    ],
)
def test_outer_sizes_and_classes(name: str, class_name: str, size: tuple[float, float, float]) -> None:
    model = catalog_object(name)
    assert model.class_name == class_name
    np.testing.assert_allclose(model.size, size, atol=0.006)


@pytest.mark.parametrize("name", TRUCKS)
def test_collision_boxes_cover_the_truck_to_30_mm_and_leave_the_space_over_the_forks(name: str) -> None:
    model = catalog_object(name)
    assert bare_distances(model).max() < 0.030
    assert filled_fraction(model) < 0.5


@pytest.mark.parametrize("name", ["forklift", "reach_truck"])
def test_forks_have_the_usual_section_and_reach_the_front(name: str) -> None:
    model = catalog_object(name)
    length = FORK_LENGTH + FORK_THICKNESS
    blades = [box for box in model.collision if np.allclose(box.size[:2], [length, FORK_WIDTH])]
    assert (FORK_LENGTH, FORK_WIDTH, FORK_THICKNESS) == (1.15, 0.10, 0.04)
    assert len(blades) == 2
    for blade in blades:
        assert blade.corners()[:, 0].max() == pytest.approx(model.size[0] / 2)
    steel = next(part for part in model.parts if part.material == "fork_steel").placed().vertices
    assert steel[:, 0].max() == pytest.approx(model.size[0] / 2)


@pytest.mark.parametrize("face", ["-x", "-y"])
def test_forks_enter_the_pockets_of_a_pallet(face: str) -> None:
    pockets = [pocket for pocket in catalog_object("epal1").pockets if pocket.face == face]
    across = 1 if face == "-x" else 0
    assert len(pockets) == 2
    for pocket in pockets:
        centre = abs(pocket.T_object_pocket[across, 3])
        for spread, width in ((FORK_SPREAD, FORK_WIDTH), (JACK_SPREAD, JACK_FORK)):
            assert abs(spread / 2 - centre) + width / 2 < pocket.size[1] / 2
        assert pocket.size[2] > FORK_THICKNESS


def test_a_lowered_jack_goes_under_a_pallet() -> None:
    jack = catalog_object("pallet_jack")
    pallet = catalog_object("epal1")
    top = next(pocket for pocket in pallet.pockets if pocket.face == "-x").size[2]
    assert top > JACK_LOWERED
    boxes = [box for box in jack.collision if box.size[0] > FORK_LENGTH]
    assert len(boxes) == 2
    for box in boxes:
        assert box.corners()[:, 2].max() == pytest.approx(JACK_LOWERED - jack.size[2] / 2)


@pytest.mark.parametrize("name", TRUCKS)
def test_wheels_stand_on_the_floor(name: str) -> None:
    model = catalog_object(name)
    tyres = next(part for part in model.parts if part.material == "rubber").placed().vertices
    assert tyres[:, 2].min() == pytest.approx(-model.size[2] / 2, abs=1e-6)


def test_trucks_have_few_parts_and_their_own_numbers() -> None:
    assert [catalog_object(name).obj_id for name in TRUCKS] == [177, 178, 176]
    assert max(len(catalog_object(name).parts) for name in TRUCKS) <= 10


# Trucks at work and finely divided people and cones: sizes, places, covering and numbers.


@pytest.mark.parametrize("name", WORKING)
def test_a_truck_stands_on_the_floor_on_its_wheels(name: str) -> None:
    model = catalog_object(name)
    floor = model.size[2] / 2 + (truck_frame(name) @ [0.0, 0.0, 0.0, 1.0])[2]
    assert abs(floor) < 0.001
    assert model.size[2] > 0.25


@pytest.mark.parametrize("name", [name for name, truck in WORKING.items() if truck.place and truck.place.forks])
def test_the_blades_have_their_top_where_loads_lie(name: str) -> None:
    place = WORKING[name].place
    assert place is not None
    assert place.forks is not None
    model, T_object_truck = catalog_object(name), truck_frame(name)
    points = model.mesh().vertices - T_object_truck[:3, 3]
    tips = points[(points[:, 0] > 0.6) & (np.abs(np.abs(points[:, 1]) - place.forks[0] / 2) < place.forks[1] / 2)]
    assert tips[:, 2].max() == pytest.approx(place.top, abs=1e-6)


@pytest.mark.parametrize("stature", WORKERS)
def test_a_fine_worker_has_the_height_of_the_coarse_one(stature: str) -> None:
    fine, coarse = (catalog_object(name) for name in (f"worker_{stature}_waiting", f"person_{stature}_standing"))
    assert fine.size[2] == pytest.approx(coarse.size[2], abs=0.003)
    assert sum(len(part.mesh.faces) for part in fine.parts) > 4 * sum(len(part.mesh.faces) for part in coarse.parts)


def test_who_kneels_or_sits_is_lower_than_who_stands() -> None:
    heights = {pose: catalog_object(f"worker_medium_{pose}").size[2] for pose in ("waiting", "seated", "kneeling")}
    assert heights["kneeling"] < 0.85 * heights["waiting"]
    assert heights["seated"] < 0.85 * heights["waiting"]


@pytest.mark.parametrize("name", FINE_CONES)
def test_a_fine_cone_has_the_size_of_the_coarse_one(name: str) -> None:
    np.testing.assert_allclose(catalog_object(name).size, catalog_object(FINE_CONES[name][1]).size, atol=1e-6)
    assert FINE_CONES[name][1] in CONES


def test_numbers_are_their_own_and_drivers_do_not_stand_about() -> None:
    names = [*WORKING, *WORKERS_BY_NAME, *FINE_CONES]
    numbers = [catalog_object(name).obj_id for name in names]
    assert len(set(numbers)) == len(names)
    assert min(numbers) >= 550
    assert max(numbers) <= 599
    assert not [name for name in FINE_STANDING["person"] if name.endswith(ON_TRUCKS)]
    assert set(FINE_STANDING) == set(STANDING)
