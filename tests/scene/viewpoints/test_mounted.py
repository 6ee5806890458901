"""Cameras as they are mounted: pitched, rolled, under the roof, along the aisle."""

import numpy as np
import pytest

from tests.scene.viewpoints.spaces import aisle_scene
from warehouse_sim.geometry.pose import invert, transform_points
from warehouse_sim.scene import Distribution
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.scene.viewpoints.single import candidate_viewpoints
from warehouse_sim.schema import Viewpoint


def views(**settings: object) -> list[tuple[Viewpoint, np.ndarray]]:
    """Return views with the centre of their target in the camera (m)."""
    space, rng = FreeSpace.of_scene(aisle_scene(0)), np.random.default_rng(0)
    found = []
    for target in space.targets:
        for view in candidate_viewpoints(target, space, ViewpointsConfig(**settings), rng):
            middle = transform_points(invert(view.T_world_camera), target.T_world_object[None, :3, 3])[0]
            found.append((view, middle))
    assert len(found) > 50
    return found


def angles_deg(view: Viewpoint) -> tuple[float, float]:
    """Return pitch and roll of a camera from where its axes point: no formula of the code is used."""
    right, _, ahead = view.T_world_camera[:3, :3].T
    level_right = np.cross(ahead, [0.0, 0.0, 1.0])
    level_right /= np.linalg.norm(level_right)
    roll = np.arctan2(right @ np.cross(ahead, level_right), right @ level_right)
    return float(np.degrees(np.arcsin(ahead[2]))), float(np.degrees(roll))


def test_pitch_and_roll_are_those_that_were_requested_for() -> None:
    pitch, roll = Distribution.uniform(-30.0, 5.0), Distribution.uniform(-3.0, 3.0)
    found = np.array([angles_deg(view) for view, _ in views(kind="post", pitch_deg=pitch, roll_deg=roll)])
    assert -30.0 <= found[:, 0].min() < -20.0
    assert 0.0 < found[:, 0].max() <= 5.0
    assert -3.0 <= found[:, 1].min() < -2.5
    assert 2.5 < found[:, 1].max() <= 3.0


@pytest.mark.parametrize("kind", ["post", "ceiling"])
def test_a_pitched_camera_has_its_target_near_its_axis(kind: str) -> None:
    for view, (x, y, z) in views(kind=kind, approach_deg=Distribution.uniform(-180.0, 180.0)):
        assert z > 0
        assert abs(np.degrees(np.arctan2(x, z))) <= 35.0
        assert abs(np.degrees(np.arctan2(y, np.hypot(x, z)))) <= 10.0
        assert view.kind == kind


def test_a_ceiling_camera_hangs_above_and_looks_down_to_straight_below() -> None:
    found = views(kind="ceiling", pitch_deg=Distribution.uniform(-90.0, -45.0))
    pitches = [angles_deg(view)[0] for view, _ in found]
    assert -90.0 <= min(pitches) < -85.0
    assert max(pitches) <= -44.99
    assert all(4.0 <= view.T_world_camera[2, 3] <= 8.0 for view, _ in found)


def test_views_along_the_aisle_look_along_it_from_anywhere_across() -> None:
    found = views(kind="post", along_fraction=1.0, distance=Distribution.uniform(3.0, 10.0))
    turned = [np.degrees(np.arctan2(view.T_world_camera[1, 2], abs(view.T_world_camera[0, 2]))) for view, _ in found]
    assert np.abs(turned).max() < 20.0
    assert {view.T_world_camera[0, 2] > 0 for view, _ in found} == {True, False}
    sides = [x / z for _, (x, _, z) in found]
    assert min(sides) < -0.15
    assert max(sides) > 0.15


def test_a_camera_may_stand_a_hand_above_the_floor() -> None:
    low = [view.T_world_camera[2, 3] for view, _ in views(kind="post", height=Distribution.uniform(0.1, 0.3))]
    assert 0.1 <= min(low) < 0.15


def test_new_settings_at_their_defaults_draw_nothing() -> None:
    space = FreeSpace.of_scene(aisle_scene(0))
    first, second = (np.random.default_rng(4) for _ in range(2))
    same = Distribution.constant(0.0)
    plain = next(candidate_viewpoints(space.targets[0], space, ViewpointsConfig(kind="amr"), first))
    named = ViewpointsConfig(kind="amr", roll_deg=same, along_fraction=0.0)
    assert (
        plain.T_world_camera.tobytes()
        == next(candidate_viewpoints(space.targets[0], space, named, second)).T_world_camera.tobytes()
    )
    assert first.random() == second.random()
