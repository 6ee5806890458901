"""Trucks at work and finely divided people and cones: sizes, places, covering and numbers."""

import numpy as np
import pytest

from tests.catalog.covering import bare_distances
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.shipped import FINE_STANDING, STANDING
from warehouse_sim.catalog.traffic.obstacles import CONES, FINE_CONES
from warehouse_sim.catalog.traffic.people import WORKERS, WORKERS_BY_NAME
from warehouse_sim.catalog.traffic.poses import ON_TRUCKS
from warehouse_sim.catalog.traffic.working import WORKING, truck_frame


@pytest.mark.parametrize("name", WORKING)
def test_collision_boxes_cover_a_truck_to_40_mm(name: str) -> None:
    assert bare_distances(catalog_object(name)).max() < 0.040


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


@pytest.mark.parametrize("name", WORKERS_BY_NAME)
def test_collision_boxes_cover_a_worker_to_40_mm(name: str) -> None:
    assert bare_distances(catalog_object(name)).max() < 0.040


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
