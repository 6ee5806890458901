"""Front ends are scored on scenes that nothing was trained on, and trained by settings that are taken."""

import pytest

from benchmarks.front_ends.data import SCORED_ON
from benchmarks.front_ends.end_to_end import CASES
from benchmarks.front_ends.score import QUESTIONS
from benchmarks.front_ends.sweeps import SWEEP_QUESTIONS
from trainings.data import CARTONS, FULLY_LABELLED, MORE_CARTONS, ROBUST, SCORED, TARGETS, TRAINED_ONLY, WITH_SWEEPS
from trainings.front_ends import PLANS, in_order
from warehouse_sim.estimators.train import trainable

POSE = (*SCORED, *CARTONS, *TRAINED_ONLY, *MORE_CARTONS, *ROBUST)


def test_no_two_datasets_draw_the_same_scenes() -> None:
    every = (*POSE, *FULLY_LABELLED, *SCORED_ON)
    sampled = [(item.recipe.split("_")[0].split("-")[0], item.seed) for item in every]
    assert len(set(sampled)) == len(sampled)
    assert len({item.folder_name for item in every}) == len(every)


@pytest.mark.parametrize("item", [*FULLY_LABELLED, *SCORED_ON], ids=lambda item: item.folder_name)
def test_recipes_load_with_their_changes(item) -> None:
    recipe = item.changed_recipe()
    assert recipe.scene.targets == TARGETS
    assert (recipe.split.test == 1.0) == (item in SCORED_ON)
    assert (recipe.split.train > 0.0) == (item in FULLY_LABELLED)
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


def test_questions_have_names_of_their_own_and_ask_of_unseen_scenes() -> None:
    names = [(question.name, name) for question in QUESTIONS for name in question.classes]
    assert len(set(names)) == len(names)
    assert {question.data for question in QUESTIONS} <= set(SCORED_ON)
    assert {case.data for case in CASES} <= set(SCORED_ON)
    requested = {stage for question in QUESTIONS for stage in question.stages}
    requested |= {question.detector for question in SWEEP_QUESTIONS}
    assert {question.data for question in SWEEP_QUESTIONS} <= set(SCORED_ON)
    assert not {question.name for question in SWEEP_QUESTIONS} & {question.name for question in QUESTIONS}
    assert requested - {"gt-boxes"} == set(PLANS)
