import pytest

from tests.catalog.covering import bare_distances
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.traffic.people import BAND, HELMET, PEOPLE, SOLE, WORKERS

STATURES = {"small": 1.535, "medium": 1.75, "tall": 1.855}
"""DIN 33402-2:2005: women's 5th, men's 50th and men's 95th percentile (m)."""


@pytest.mark.parametrize("stature", STATURES)
def test_a_standing_worker_is_as_tall_as_the_standard_says_with_shoes_and_helmet(stature: str) -> None:
    height = catalog_object(f"person_{stature}_standing").size[2]
    assert WORKERS[stature].stature == STATURES[stature]
    assert height == pytest.approx(STATURES[stature] + SOLE + HELMET, abs=0.006)


@pytest.mark.parametrize("stature", STATURES)
def test_a_walking_worker_strides(stature: str) -> None:
    standing, walking = (catalog_object(f"person_{stature}_{pose}") for pose in ("standing", "walking"))
    assert walking.size[2] < standing.size[2]
    # A step is 0.4-0.5 of the stature; shoes add their length.
    assert 0.45 * STATURES[stature] < walking.size[0] < 0.65 * STATURES[stature]


@pytest.mark.parametrize("name", PEOPLE)
def test_shoulders_are_wider_than_hips_and_the_body_is_upright(name: str) -> None:
    model = catalog_object(name)
    assert model.class_name == "person"
    assert 0.28 < model.size[1] / WORKERS[name.split("_")[1]].stature < 0.37
    assert 50.0 < model.mass < 110.0


@pytest.mark.parametrize("name", PEOPLE)
def test_collision_boxes_cover_the_body_to_25_mm(name: str) -> None:
    assert bare_distances(catalog_object(name)).max() < 0.025


@pytest.mark.parametrize("name", PEOPLE)
def test_bands_lie_around_the_vest(name: str) -> None:
    model = catalog_object(name)
    parts = {part.material: part.placed().vertices for part in model.parts}
    assert {"reflective", "rubber", WORKERS[name.split("_")[1]].vest} <= set(parts)
    foot = -model.size[2] / 2
    bands = parts["reflective"][:, 2] - foot
    height = WORKERS[name.split("_")[1]].stature
    assert 0.5 * height < bands.min() < 0.6 * height
    assert 0.78 * height < bands.max() < 0.88 * height
    assert BAND == 0.05


def test_each_stands_on_a_sole() -> None:
    for name in PEOPLE:
        model = catalog_object(name)
        lowest = {part.material: part.placed().vertices[:, 2].min() for part in model.parts}
        assert min(lowest, key=lambda material: lowest[material]) == "rubber"
        assert lowest["rubber"] == pytest.approx(-model.size[2] / 2)
