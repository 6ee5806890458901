import numpy as np
import pytest

from tests.catalog.covering import bare_distances, filled_fraction
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.traffic.truck_pieces import FORK_LENGTH, FORK_SPREAD, FORK_THICKNESS, FORK_WIDTH
from warehouse_sim.catalog.traffic.trucks import JACK_FORK, JACK_LOWERED, JACK_SPREAD

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
