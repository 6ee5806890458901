"""No scene that a suite scores may be one that the bundled weights were trained on."""

from trainings import uncertainty, warehouses
from trainings.data import FULLY_LABELLED, MORE_CARTONS, PALLETS, ROBUST, TRAINED_ONLY
from warehouse_sim.benchmark.suite import load_suite
from warehouse_sim.resources import suite_names
from warehouse_sim.sensors.rgbd.depth import PRESETS

EVERY = (*PALLETS, *TRAINED_ONLY, *MORE_CARTONS, *ROBUST, *FULLY_LABELLED)


def test_datasets_of_the_same_scenes_have_other_seeds() -> None:
    # A recipe that extends another has its scenes; the first word of a name tells which.
    sampled = [(item.recipe.split("_")[0].split("-")[0], item.seed) for item in EVERY]
    assert len(set(sampled)) == len(sampled)
    assert len({item.folder_name for item in EVERY}) == len(EVERY)


def test_no_suite_has_a_seed_of_a_training() -> None:
    suites = [load_suite(name) for name in suite_names()]
    scored = {data.seed for suite in suites for data in suite.data.values()}
    scored |= {suite.approach.seed for suite in suites if suite.approach.recipes}
    scored |= {suite.negatives.seed for suite in suites if suite.negatives.recipes}
    assert len(scored) > 20
    assert not scored & {item.seed for item in EVERY}
    assert not scored & {warehouses.part(number).seed for number in range(1042)}
    assert uncertainty.SEED not in scored


def test_robust_data_see_through_every_depth_preset_several_lenses_and_share_their_pallets():
    recipes = [item.changed_recipe() for item in ROBUST]
    for recipe in recipes:
        assert {choice.rgbd.depth for choice in recipe.sensors.choices} >= {
            model for name, model in PRESETS.items() if not name.endswith("_720p")
        }
        pitch, roll = recipe.scene.viewpoints.pitch_deg, recipe.scene.viewpoints.roll_deg
        assert (pitch.low, pitch.high) == (-30.0, 10.0)
        assert (roll.low, roll.high) == (-6.0, 6.0)
        assert recipe.split.test == 0.0
    cameras = {recipe.sensors.camera for recipe in recipes}
    assert len(cameras) == 4
    assert any(camera.distortion for camera in cameras)
    # Objects of one number must be one geometry where sets are trained on together.
    sampled = {recipe.scene.loads.sampled_pallets for recipe in recipes if recipe.scene.loads.sampled_pallets.fraction}
    assert len(sampled) == 1
