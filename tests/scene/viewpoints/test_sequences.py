from functools import cache

import numpy as np
import pytest

from tests.scene.viewpoints.spaces import aisle_scene, bare_space
from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.pose import invert
from warehouse_sim.scene.viewpoints.choose import choose_drives
from warehouse_sim.scene.viewpoints.config import DriveConfig, ViewpointsConfig
from warehouse_sim.scene.viewpoints.framing import shows
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.scene.viewpoints.mountings import MOUNTINGS
from warehouse_sim.scene.viewpoints.plans import entries_of
from warehouse_sim.schema import Viewpoint

TRAJECTORIES = ("drive", "turn_in", "approach")
VEHICLES = ("forklift_mast", "forklift_forks", "forklift_guard", "amr", "level")


@cache
def frames(
    trajectory: str, kind: str = "forklift_forks", count: int = 41, index: int = 0, **settings: object
) -> tuple[tuple[Viewpoint, ...], FreeSpace, ViewpointsConfig]:
    space = FreeSpace.of_scene(aisle_scene(index, staged=1))
    config = ViewpointsConfig(kind=kind, trajectory=trajectory, max_elevation_deg=13.0, **settings)
    return choose_drives(space, count, config, MOUNTINGS[kind], np.random.default_rng(index)), space, config


def flat(view: Viewpoint) -> tuple[np.ndarray, float]:
    T = view.T_world_vehicle
    return T[:2, 3], float(np.arctan2(T[1, 0], T[0, 0]))


@pytest.mark.parametrize("trajectory", TRAJECTORIES)
def test_a_sequence_is_even_in_time_and_begins_at_zero(trajectory: str) -> None:
    views, _, _ = frames(trajectory)
    times = [view.time for view in views]
    assert times[0] == 0.0
    np.testing.assert_allclose(np.diff(times), times[1])
    assert {view.sequence for view in views} == {0}
    assert {view.kind for view in views} == {"forklift_forks"}


@pytest.mark.parametrize("kind", VEHICLES)
@pytest.mark.parametrize("trajectory", TRAJECTORIES)
def test_every_frame_shows_its_target_and_has_room(trajectory: str, kind: str) -> None:
    views, space, config = frames(trajectory, kind, count=15, index=1)
    vehicle = MOUNTINGS[kind].vehicle
    for view in views:
        target = next(item for item in space.targets if item.instance_id == view.target)
        assert shows(view, target, space, config)
        distance = space.solids.boxes.distances_to(view.T_world_camera[:3, 3])
        assert distance[space.solids.owner != 1].min() >= 0.7
        if vehicle is not None:
            assert space.admits_bodies(vehicle.boxes(view.T_world_vehicle)[:1])


def test_a_turn_in_turns_by_a_right_angle_and_ends_before_its_target() -> None:
    views, space, _ = frames("turn_in")
    (_, first), (_, last) = flat(views[0]), flat(views[-1])
    assert np.abs(np.angle(np.exp(1j * (last - first)))) == pytest.approx(np.pi / 2, abs=1e-9)
    rates = np.array([view.yaw_rate for view in views])
    assert (rates == 0.0).any()
    assert (rates != 0.0).sum() >= 5
    target = next(item for item in space.targets if item.instance_id == views[-1].target)
    assert not space.in_aisle(target)
    assert abs(np.sin(first)) < np.sin(np.deg2rad(8.0))  # along the aisle, but for the load's and the driver's error


def test_an_approach_is_straight_slows_down_and_stops_before_the_pockets() -> None:
    views, space, _ = frames("approach", index=1)
    speeds = np.array([np.hypot(*view.velocity[:2]) for view in views])
    assert speeds[-1] == pytest.approx(0.0, abs=1e-9)
    assert (np.diff(speeds) <= 1e-9).all()
    assert 0.3 <= speeds[0] <= 0.8
    target = next(item for item in space.targets if item.instance_id == views[0].target)
    tip = MOUNTINGS["forklift_forks"].tip
    gaps = []
    for view in views:
        local = [
            (invert(view.T_world_vehicle) @ np.array([entry.x, entry.y, 0.0, 1.0]))[:2]
            for entry in entries_of(target, space.models[target.model])
        ]
        ahead, aside = min(local, key=np.linalg.norm)
        gaps.append(ahead - tip)
        assert abs(aside) < 0.15 + ahead * np.sin(np.deg2rad(5.0))
    assert 0.75 <= gaps[-1] <= 1.0
    assert 4.5 <= gaps[0] <= 6.0


def test_observations_are_shared_out_among_drives() -> None:
    views, _, _ = frames("drive", count=11, drive=DriveConfig(drives=3))
    assert [view.sequence for view in views] == [0] * 4 + [1] * 4 + [2] * 3
    assert [view.time for view in views].count(0.0) == 3


def test_views_on_their_own_are_moments_of_different_drives() -> None:
    views, _, _ = frames("approach", count=6, drive=DriveConfig(sequence=False))
    assert {view.sequence for view in views} == {None}
    assert {view.time for view in views} == {0.0}
    assert len({view.T_world_vehicle[:2, :2].tobytes() for view in views}) == 6
    assert max(np.hypot(*view.velocity[:2]) for view in views) > 0.1


def test_a_drive_that_finds_no_room_says_what_to_widen() -> None:
    walls = [("carton_600x400x400", (x, y, 0.2), 0.0) for x in (-2.5, 2.5) for y in (-7.0, -5.0, -4.0, -3.0, -1.0)]
    space = bare_space(("epal1", (0.0, -4.0, 0.072), 0.0), *walls)
    config = ViewpointsConfig(kind="forklift_mast", trajectory="approach", max_elevation_deg=2.0)
    with pytest.raises(PlacementError, match=r"no approach of kind forklift_mast found in 40 tries .* widen layout"):
        choose_drives(space, 3, config, MOUNTINGS["forklift_mast"], np.random.default_rng(0))
