from pathlib import Path

import pytest

from warehouse_sim.config import load_yaml, to_mapping
from warehouse_sim.errors import RecipeError
from warehouse_sim.scene import SceneRecipe, sample_scene

BAD = [
    ("viewpoints: {kind: drone}", "kind must be one of 'level', 'forklift_mast'"),
    ("viewpoints: {kind: free, trajectory: drive}", "a free camera does not drive"),
    ("viewpoints: {kind: level, pitch_deg: -5}", "a level camera has no pitch"),
    ("viewpoints: {kind: amr, level: true, pitch_deg: -5}", "a level camera has no pitch"),
    ("viewpoints: {kind: level, roll_deg: 2}", "a level camera has no roll"),
    ("viewpoints: {kind: post, level: true, roll_deg: {min: -1, max: 1}}", "a level camera has no roll"),
    ("viewpoints: {kind: post, roll_deg: 11}", "roll_deg must stay within -10 to 10 deg"),
    ("viewpoints: {kind: ceiling, level: true}", "a ceiling camera neither looks along the horizon nor drives"),
    ("viewpoints: {kind: ceiling, trajectory: drive}", "a ceiling camera neither looks along the horizon nor drives"),
    ("viewpoints: {along_fraction: 2}", "along_fraction must be 0-1, found 2"),
    (
        "viewpoints: {kind: amr, pitch_deg: {mean: 0, std: 3}}",
        r"pitch_deg must stay within -90 to 60 deg, found -inf; give it min and max",
    ),
    ("viewpoints: {min_targets: 0}", "min_targets must be 1-20, found 0"),
    ("viewpoints: {max_bearing_deg: 90}", "max_bearing_deg must be 1-80 deg, found 90.0"),
    ("viewpoints: {sight_fraction: 1.1}", "sight_fraction must be 0-1, found 1.1"),
    ("viewpoints: {drive: {drives: 0}}", "drives must be 1-100, found 0"),
    ("viewpoints: {drive: {start: 1.6, stop: 2}}", "stop must stay below start, found 2.0 and 1.6"),
    ("viewpoints: {drive: {speed: 9}}", "speed must stay within 0.1-6 m/s"),
    ("viewpoints: {drive: {acceleration: 0}}", "acceleration must be 0.05-5 m/s"),
    ("viewpoints: {drive: {radius: 0.1}}", "radius must stay within 0.3-6 m"),
]


@pytest.mark.parametrize(("text", "message"), BAD)
def test_a_bad_setting_is_one_line(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with pytest.raises(RecipeError, match=message) as caught:
        load_yaml(SceneRecipe, path, RecipeError)
    assert str(caught.value).startswith(f"{path}: viewpoints")
    assert "\n" not in str(caught.value)


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
