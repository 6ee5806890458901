import numpy as np
import pytest

from warehouse_sim.geometry.pose import invert, transform_points
from warehouse_sim.scene import Distribution, SceneRecipe, sample_scene
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.schema import SceneSpec

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
