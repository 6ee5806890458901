"""People and trucks at work are labelled where a recipe requires them."""

from warehouse_sim.config import from_mapping
from warehouse_sim.generation.plan import target_models
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.scene import sample_scene

SCENE = {
    "layout": {"kind": "rack_aisle", "bays": 1, "beam_levels": [1.45], "aisle_width": 8.0},
    "traffic": {"detail": "fine", "people": 1, "forklifts": 1, "pallet_jacks": 0, "cones": 1},
    "staging": {"count": 1},
    "observations_per_scene": 1,
    "targets": ["pallet", "person", "forklift"],
}


def recipe(**changed: object) -> Recipe:
    return from_mapping(Recipe, {"description": "people", "name": "people", "scene": SCENE | changed}, "people.yaml")


def test_every_target_of_a_scene_is_a_geometry_that_labels_can_name() -> None:
    requested = recipe()
    known = {model.obj_id: model for model in target_models(requested)}
    assert {model.class_name for model in known.values()} == {"pallet", "person", "forklift"}
    scene = sample_scene(requested.scene, 3, 0)
    found = [scene.model_of(item) for item in scene.target_instances()]
    assert {model.class_name for model in found} >= {"pallet", "person", "forklift"}
    for model in found:
        assert known[model.obj_id].class_name == model.class_name
        # One number is one geometry.
        assert len(known[model.obj_id].parts) == len(model.parts)


def test_who_does_not_ask_gets_the_models_of_before() -> None:
    plain = target_models(recipe(targets=["pallet"]))
    assert {model.class_name for model in plain} == {"pallet"}
