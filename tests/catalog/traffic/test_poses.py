"""Whoever stands, walks or kneels has two contacts with the floor at least."""

import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.traffic.people import PEOPLE, WORKERS, WORKERS_BY_NAME
from warehouse_sim.catalog.traffic.poses import WORKER_POSES, Pose, planted

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
