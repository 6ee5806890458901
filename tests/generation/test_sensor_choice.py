"""A recipe draws its camera a scene; the dataset says which, and reads back."""

from pathlib import Path

import numpy as np

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.stored.scene_record import read_scene_record
from warehouse_sim.dataset.validate import validate
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.recipe.difficulty import with_difficulty
from warehouse_sim.generation.scene import prepare_scene

SMALL = {"width": 408, "height": 124, "focal_px": 240}
CHOICES = [
    {"name": "exact", "depth": {"model": "ideal"}, "color": "ideal"},
    {"name": "noisy", "depth": {"model": "quadratic", "sigma_base": 0.02}, "color": "ideal"},
]


def recipe_with(**sensors: object) -> Recipe:
    plain = to_mapping(load_recipe("smoke"))
    plain["sensors"] |= {"camera": SMALL, "lidar": None, "outputs": ["default", "clean"], **sensors}
    plain["scene"]["observations_per_scene"] = 1
    found: Recipe = from_mapping(Recipe, plain, "here")
    return found


def test_each_scene_is_read_by_the_camera_that_it_says(tmp_path: Path) -> None:
    recipe = recipe_with(choices=CHOICES)
    generate(recipe, tmp_path, GenerateConfig(scenes=3, seed=1, formats=("bop",)))
    assert [check.detail for check in validate(tmp_path) if not check.ok] == []
    named = set()
    reader = DatasetReader(tmp_path)
    for image in (image for split in reader.splits for image in reader.images(split)):
        sensor = read_scene_record(tmp_path, image.scene_id).observations[image.image_id].conditions.sensor
        named.add(sensor)
        read, true = reader.depth(image), reader.clean_depth(image)
        if sensor == "exact":
            assert np.abs(read - true)[read > 0].max() < 1e-3
        else:
            assert np.std((read - true)[read > 0]) > 0.01
    assert named == {"exact", "noisy"}


def test_scenes_and_views_are_those_of_one_camera() -> None:
    """Which camera reads must not move what it looks at."""
    one, sampled = prepare_scene(recipe_with(), 1, 0), prepare_scene(recipe_with(choices=CHOICES), 1, 0)
    for before, after in zip(one.scene.viewpoints, sampled.scene.viewpoints, strict=True):
        assert np.array_equal(before.T_world_camera, after.T_world_camera)
    for before, after in zip(one.scene.instances, sampled.scene.instances, strict=True):
        assert np.array_equal(before.T_world_object, after.T_world_object)


def test_the_difficulty_dial_moves_the_noise_of_every_choice() -> None:
    noisy = with_difficulty(recipe_with(choices=["d455", "flexx2"]), 1.0)
    assert [choice.rgbd.depth.noise_scale for choice in noisy.sensors.choices] == [4.0, 4.0]
    assert [choice.rgbd.color.noise_scale for choice in noisy.sensors.choices] == [1.4, 1.4]
