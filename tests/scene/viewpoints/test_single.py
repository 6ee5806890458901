import numpy as np
import pytest

from tests.scene.viewpoints.spaces import aisle_scene, bare_space
from warehouse_sim.geometry.pose import invert, transform_points
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene import Distribution, SceneRecipe, sample_scene
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.scene.viewpoints.framing import angles_to, shows
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.scene.viewpoints.mountings import MOUNTINGS
from warehouse_sim.scene.viewpoints.single import candidate_viewpoints
from warehouse_sim.schema import SceneSpec, Viewpoint

KINDS = ("level", "forklift_mast", "forklift_forks", "forklift_guard", "amr", "free")


def views(kind: str, index: int, count: int, **settings: object) -> list[tuple[Viewpoint, FreeSpace]]:
    """Return views of the first targets that can be seen at all."""
    space, rng, found = FreeSpace.of_scene(aisle_scene(index)), np.random.default_rng(0), []
    config = ViewpointsConfig(kind=kind, **settings)
    for target in space.targets[:16]:
        for view in candidate_viewpoints(target, space, config, rng):
            if shows(view, target, space, config):
                found.append((view, space))
                break
    assert len(found) >= count
    return found


@pytest.mark.parametrize("level", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_looks_at_its_target_from_where_it_is_mounted(kind: str, level: bool) -> None:
    pitches = []
    for view, space in views(kind, 0, 4, level=level):
        target = next(item for item in space.targets if item.instance_id == view.target)
        bearing, elevation = angles_to(view.T_world_camera, target.T_world_object[None, :3, 3])
        assert bearing[0] <= np.deg2rad(15.5)  # a little more than on the floor where the camera is tilted
        assert elevation[0] <= np.deg2rad(10.0) + 1e-9
        T = view.T_world_camera
        assert T[2, 0] == pytest.approx(0.0, abs=1e-12)  # no roll
        pitches.append(np.rad2deg(np.arcsin(T[2, 2])))
        assert view.kind == kind
        assert view.velocity == (0.0, 0.0, 0.0)
        if kind == "free":
            assert view.T_world_vehicle is None
        else:
            x, y, z = (invert(view.T_world_vehicle) @ T)[:3, 3]
            assert (x, y) == pytest.approx((MOUNTINGS[kind].forward, 0.0), abs=1e-9)
            assert z >= MOUNTINGS[kind].height.low
            assert view.T_world_vehicle[2, 3] == 0.0
    if level:
        assert np.abs(pitches).max() < 1e-6
    elif kind in ("forklift_mast", "forklift_guard"):
        assert max(pitches) < -4.9
    elif kind != "level":
        assert np.ptp(pitches) > 1.0


@pytest.mark.parametrize("kind", KINDS)
def test_rays_say_that_cameras_are_free_and_vehicles_stand_in_nothing(kind: str) -> None:
    rng = np.random.default_rng(1)
    caster = RayCaster(aisle_scene(1))
    for view, space in views(kind, 1, 4):
        directions = rng.normal(size=(400, 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        hits = caster.cast(np.repeat(view.T_world_camera[None, :3, 3], 400, axis=0), directions)
        floor = hits.instance_ids == 1
        assert hits.distance[~floor].min() >= 0.69
        assert hits.distance.min() >= 0.09
        vehicle = MOUNTINGS[kind].vehicle if kind in MOUNTINGS else None
        if vehicle is not None:
            assert space.admits_bodies(vehicle.boxes(view.T_world_vehicle)[:1])


def test_a_free_camera_is_on_the_shell_and_looks_at_the_middle() -> None:
    space = bare_space(("epal1", (0.0, -4.0, 0.072), 0.3))
    config = ViewpointsConfig(
        kind="free", distance=Distribution.uniform(2.0, 3.0), elevation_deg=Distribution.uniform(20.0, 70.0)
    )
    found = list(candidate_viewpoints(space.targets[0], space, config, np.random.default_rng(0), tries=50))
    assert len(found) == 50
    azimuths = []
    for view in found:
        line = space.targets[0].T_world_object[:3, 3] - view.T_world_camera[:3, 3]
        distance = np.linalg.norm(line)
        assert 2.0 <= distance <= 3.0
        np.testing.assert_allclose(view.T_world_camera[:3, 2], line / distance, atol=1e-12)
        assert 20.0 <= np.rad2deg(np.arcsin(-line[2] / distance)) <= 70.0
        azimuths.append(np.arctan2(line[1], line[0]))
    assert np.histogram(azimuths, 4, (-np.pi, np.pi))[0].min() >= 5


def test_candidates_can_be_requested_to_be_hidden() -> None:
    space = FreeSpace.of_scene(aisle_scene(0))
    rng, fractions = np.random.default_rng(0), []
    for target in space.targets:
        for view in candidate_viewpoints(target, space, ViewpointsConfig(), rng, sight=(0.1, 0.5)):
            fractions.append(space.sight_fraction(view.T_world_camera[:3, 3], target))
    assert len(fractions) > 10
    assert 0.1 <= min(fractions) <= max(fractions) <= 0.5


def test_forks_go_no_higher_than_the_target() -> None:
    for view, space in views("forklift_forks", 0, 4):
        target = next(item for item in space.targets if item.instance_id == view.target)
        stands_at = target.T_world_object[2, 3] - space.models[target.model].size[2] / 2
        assert 0.25 <= view.T_world_camera[2, 3] <= 0.55 + stands_at + 1e-9


def views_of_all(**settings: object) -> list[tuple[Viewpoint, np.ndarray]]:
    """Return views_of_all with the centre of their target in the camera (m)."""
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
    found = np.array([angles_deg(view) for view, _ in views_of_all(kind="post", pitch_deg=pitch, roll_deg=roll)])
    assert -30.0 <= found[:, 0].min() < -20.0
    assert 0.0 < found[:, 0].max() <= 5.0
    assert -3.0 <= found[:, 1].min() < -2.5
    assert 2.5 < found[:, 1].max() <= 3.0


@pytest.mark.parametrize("kind", ["post", "ceiling"])
def test_a_pitched_camera_has_its_target_near_its_axis(kind: str) -> None:
    for view, (x, y, z) in views_of_all(kind=kind, approach_deg=Distribution.uniform(-180.0, 180.0)):
        assert z > 0
        assert abs(np.degrees(np.arctan2(x, z))) <= 35.0
        assert abs(np.degrees(np.arctan2(y, np.hypot(x, z)))) <= 10.0
        assert view.kind == kind


def test_a_ceiling_camera_hangs_above_and_looks_down_to_straight_below() -> None:
    found = views_of_all(kind="ceiling", pitch_deg=Distribution.uniform(-90.0, -45.0))
    pitches = [angles_deg(view)[0] for view, _ in found]
    assert -90.0 <= min(pitches) < -85.0
    assert max(pitches) <= -44.99
    assert all(4.0 <= view.T_world_camera[2, 3] <= 8.0 for view, _ in found)


def test_views_along_the_aisle_look_along_it_from_anywhere_across() -> None:
    found = views_of_all(kind="post", along_fraction=1.0, distance=Distribution.uniform(3.0, 10.0))
    turned = [np.degrees(np.arctan2(view.T_world_camera[1, 2], abs(view.T_world_camera[0, 2]))) for view, _ in found]
    assert np.abs(turned).max() < 20.0
    assert {view.T_world_camera[0, 2] > 0 for view, _ in found} == {True, False}
    sides = [x / z for _, (x, _, z) in found]
    assert min(sides) < -0.15
    assert max(sides) > 0.15


def test_a_camera_may_stand_a_hand_above_the_floor() -> None:
    low = [view.T_world_camera[2, 3] for view, _ in views_of_all(kind="post", height=Distribution.uniform(0.1, 0.3))]
    assert 0.1 <= min(low) < 0.15


HALF_WIDTH_OVER_FOCAL, HALF_HEIGHT_OVER_FOCAL = 612 / 721.5, 185 / 721.5
"""Half the image of the KITTI camera (1224 x 370, focal length 721.5 px) at unit distance."""


@pytest.fixture(scope="module", params=["one", "both"])
def scenes(request: pytest.FixtureRequest) -> list[SceneSpec]:
    recipe = SceneRecipe(layout=RackAisleConfig(sides=request.param), observations_per_scene=10)
    return [sample_scene(recipe, 5, index) for index in range(4)]


def test_cameras_are_level_and_within_the_height_range(scenes: list[SceneSpec]) -> None:
    for scene in scenes:
        assert len(scene.viewpoints) == 10
        for view in scene.viewpoints:
            T = view.T_world_camera
            np.testing.assert_allclose(T[:3, 1], [0, 0, -1], atol=1e-12)  # image down is world down
            assert abs(T[2, 2]) < 1e-12  # looks along the horizon
            assert 0.4 <= T[2, 3] <= 3.5


def test_every_view_holds_a_target_in_the_distance_range(scenes: list[SceneSpec]) -> None:
    for scene in scenes:
        targets = np.array([item.T_world_object[:3, 3] for item in scene.target_instances()])
        for view in scene.viewpoints:
            x, y, z = transform_points(invert(view.T_world_camera), targets).T
            distance = np.hypot(x, z)
            bearing, elevation = np.degrees(np.arctan2(x, z)), np.abs(y) / distance
            good = (distance >= 2.0) & (distance <= 8.0) & (np.abs(bearing) <= 15.0 + 1e-9)
            good &= elevation <= np.tan(np.radians(10.0)) + 1e-9
            assert good.any()
            shown = (np.abs(x[good]) < HALF_WIDTH_OVER_FOCAL * z[good]) & (
                np.abs(y[good]) < HALF_HEIGHT_OVER_FOCAL * z[good]
            )
            assert shown.all()


def test_both_racks_of_an_aisle_are_looked_at() -> None:
    recipe = SceneRecipe(layout=RackAisleConfig(sides="both"), observations_per_scene=30)
    forward = [view.T_world_camera[1, 2] for view in sample_scene(recipe, 0, 0).viewpoints]
    assert min(forward) < -0.5 < 0.5 < max(forward)


def test_distances_spread_over_the_whole_range() -> None:
    recipe = SceneRecipe(
        viewpoints=ViewpointsConfig(distance=Distribution.uniform(2.0, 8.0)), observations_per_scene=200
    )
    scene = sample_scene(recipe, 0, 0)
    front = [-view.T_world_camera[1, 3] for view in scene.viewpoints]
    assert min(front) < 2.0
    assert max(front) > 6.5


@pytest.mark.parametrize(("fraction", "low", "high"), [(0.0, 0, 0), (0.5, 10, 30), (1.0, 40, 40)])
def test_the_share_of_views_at_the_aisles_loads_is_kept(fraction: float, low: int, high: int) -> None:
    config = ViewpointsConfig(
        aisle_fraction=fraction, offset_deg=Distribution.constant(0.0), approach_deg=Distribution.constant(0.0)
    )
    # Scene 0: each of its loads in the aisle can be seen from somewhere, so that none has to be given up.
    scene = sample_scene(SceneRecipe(viewpoints=config, observations_per_scene=40), 0, 0)
    targets = np.array([item.T_world_object[:3, 3] for item in scene.target_instances()])
    aimed_at = []
    for view in scene.viewpoints:  # straight ahead: the aimed-at pallet is on the optical axis, seen from above
        x, _, z = transform_points(invert(view.T_world_camera), targets).T
        aimed_at.append(targets[(np.abs(x) < 1e-6) & (z > 0)][0])
    assert low <= sum(target[1] < 0.0 for target in aimed_at) <= high
