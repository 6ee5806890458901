"""No scene that estimators are scored on may be one that they were trained on."""

from benchmarks.estimators.data import CARTONS, MORE_CARTONS, SCORED, TRAINED_ONLY

EVERY = (*SCORED, *CARTONS, *TRAINED_ONLY, *MORE_CARTONS)


def test_datasets_that_draw_the_same_scenes_have_other_seeds():
    # A recipe that extends another draws its scenes; the first word of a name tells which.
    drawn = [(item.recipe.split("_")[0], item.seed) for item in EVERY]
    assert len(set(drawn)) == len(drawn)
    assert len({item.folder_name for item in EVERY}) == len(EVERY)


def test_scored_cartons_are_all_test():
    for item in CARTONS:
        recipe = item.changed_recipe()
        assert (recipe.split.train, recipe.split.val, recipe.split.test) == (0.0, 0.0, 1.0)
        assert recipe.name == item.folder_name
        assert "carton" in recipe.scene.targets
