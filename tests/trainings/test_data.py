"""No scene that estimators are scored on may be one that they were trained on."""

from trainings.data import CARTONS, MORE_CARTONS, ROBUST, SCORED, TRAINED_ONLY
from warehouse_sim.sensors.rgbd.depth import PRESETS

EVERY = (*SCORED, *CARTONS, *TRAINED_ONLY, *MORE_CARTONS, *ROBUST)


def test_datasets_that_draw_the_same_scenes_have_other_seeds():
    # A recipe that extends another draws its scenes; the first word of a name tells which.
    sampled = [(item.recipe.split("_")[0], item.seed) for item in EVERY]
    assert len(set(sampled)) == len(sampled)
    assert len({item.folder_name for item in EVERY}) == len(EVERY)


def test_scored_cartons_are_all_test():
    for item in CARTONS:
        recipe = item.changed_recipe()
        assert (recipe.split.train, recipe.split.val, recipe.split.test) == (0.0, 0.0, 1.0)
        assert recipe.name == item.folder_name
        assert "carton" in recipe.scene.targets


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
