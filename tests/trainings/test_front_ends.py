"""Front ends are trained by recipes that load and by settings that are taken."""

import pytest

from trainings.data import FULLY_LABELLED, TARGETS, WITH_SWEEPS
from trainings.front_ends import PLANS, in_order
from warehouse_sim.estimators.train import trainable


@pytest.mark.parametrize("item", FULLY_LABELLED, ids=lambda item: item.folder_name)
def test_recipes_load_with_their_changes(item) -> None:
    recipe = item.changed_recipe()
    assert recipe.scene.targets == TARGETS
    assert recipe.split.train > 0.0
    assert recipe.split.test == 0.0
    if "kitti" in item.formats:
        assert recipe.sensors.lidar is not None
        assert (recipe.sensors.camera.width, recipe.sensors.camera.height) == (1224, 370)


@pytest.mark.parametrize("name", PLANS)
def test_a_plan_is_for_what_it_trains(name: str) -> None:
    plan = PLANS[name].limited(11.0, None, 32, 16, 1)
    assert type(plan.config) is type(trainable(name).settings)
    assert (plan.config.max_minutes, plan.config.workers) == (11.0, 16)
    if "person" in getattr(plan.config, "classes", ()):
        assert not plan.pose, "people are not labelled there"
    if name in ("detector-lidar", "detector-sweep"):
        assert getattr(plan.config, "depth_source", "lidar") == "lidar"
        assert plan.own == WITH_SWEEPS
        assert not plan.pose


def test_methods_are_trained_in_the_order_of_their_use() -> None:
    assert in_order(["segmenter-rgb", "detector-depth"]) == ["detector-depth", "segmenter-rgb"]
    with pytest.raises(SystemExit, match="detector-depht"):
        in_order(["detector-depht"])
