from warehouse_sim.config import to_mapping
from warehouse_sim.scene import SceneRecipe, sample_scene


def test_the_kind_can_be_left_open_and_each_scene_has_one() -> None:
    plain = {
        "layout": {"bays": 2, "beam_levels": [1.45]},
        "viewpoints": {"kind": {"choices": ["amr", "free", "level"]}},
        "observations_per_scene": 2,
    }
    recipe = SceneRecipe.from_plain(plain, "here")
    assert SceneRecipe.from_plain(to_mapping(recipe), "here") == recipe
    kinds = [{view.kind for view in sample_scene(recipe, 0, index).viewpoints} for index in range(7)]
    assert all(len(kind) == 1 for kind in kinds)
    assert set.union(*kinds) == {"amr", "free", "level"}


def test_a_recipe_can_ask_for_level_sequences() -> None:
    plain = {
        "layout": {"bays": 3, "beam_levels": [1.45]},
        "staging": {"count": 0},
        "viewpoints": {"kind": "forklift_forks", "trajectory": "approach", "level": True, "drive": {"drives": 2}},
        "observations_per_scene": 7,
    }
    views = sample_scene(SceneRecipe.from_plain(plain, "here"), 0, 0).viewpoints
    assert [view.sequence for view in views] == [0] * 4 + [1] * 3
    assert all(abs(view.T_world_camera[2, 2]) < 1e-12 for view in views)
