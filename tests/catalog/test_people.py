import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.traffic.people import BAND, HELMET, PEOPLE, SOLE, WORKERS, WORKERS_BY_NAME
from warehouse_sim.catalog.traffic.poses import WORKER_POSES, Pose, planted

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


# Whoever stands, walks or kneels has two contacts with the floor at least.


ON_FOOT = [name for name in (*PEOPLE, *WORKERS_BY_NAME) if not name.endswith("seated")]
CONTACT = 0.01


def heights(name: str, material: str) -> list[float]:
    """Return the heights over the floor of the lowest points of a person's parts of one material (m)."""
    model = catalog_object(name)
    floor = -model.size[2] / 2
    return [float(part.placed().vertices[:, 2].min()) - floor for part in model.parts if part.material == material]


@pytest.mark.parametrize("name", ON_FOOT)
def test_both_soles_are_on_the_floor(name: str) -> None:
    assert all(abs(height) < CONTACT for height in heights(name, "rubber"))


@pytest.mark.parametrize("stature", WORKERS)
def test_who_kneels_has_a_knee_on_the_floor_too(stature: str) -> None:
    assert abs(min(heights(f"worker_{stature}_kneeling", WORKERS[stature].trousers))) < CONTACT


def test_legs_of_two_sticks_come_down_to_the_floor() -> None:
    """Without shoes and thickness the hip is as high as the longer leg is, and both are as long then."""

    def reach(pose: Pose, number: int) -> tuple[float, float]:
        thigh, shank = np.cos(np.deg2rad([pose.thighs[number], pose.shanks[number]]))
        return float(thigh + shank), float(thigh)

    standing = Pose((40.0, -14.0), (-4.0, -20.0), (0.0, 0.0), (0.0, 0.0), (0.0, 0.0))
    found = planted(standing, reach)
    assert found.thighs[1] == standing.thighs[1]
    assert reach(found, 0)[0] == pytest.approx(reach(standing, 1)[0], abs=1e-4)
    assert 0.0 < found.thighs[0] < 40.0


def test_who_sits_and_who_stands_already_keeps_the_pose() -> None:
    def even(pose: Pose, number: int) -> tuple[float, float]:
        return 0.9, 0.4

    assert planted(WORKER_POSES["waiting"], even) is WORKER_POSES["waiting"]
    assert planted(WORKER_POSES["seated"], even) is WORKER_POSES["seated"]
