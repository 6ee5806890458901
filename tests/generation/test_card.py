"""The card's own recipe makes the dataset again, and its licences are those of what took part."""

from pathlib import Path

import pytest

from warehouse_sim.dataset.card.of_dataset import write_recipe
from warehouse_sim.dataset.card.text import OWNERS
from warehouse_sim.generation.plan import GenerateConfig, plan_dataset, recipe_licences, texture_licence
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.recipe.difficulty import with_difficulty


@pytest.mark.parametrize("name", ["smoke", "industrial-v1", "domain_random", "selective_rack", "lighting_study"])
def test_the_stored_recipe_describes_the_same_dataset(name: str, tmp_path: Path) -> None:
    config = GenerateConfig(scenes=2)
    manifest = plan_dataset(load_recipe(name), config).manifest
    write_recipe(tmp_path / "card" / "recipe.yaml", manifest)
    assert plan_dataset(load_recipe(str(tmp_path / "card" / "recipe.yaml")), config).manifest == manifest


def test_a_difficulty_is_in_the_stored_recipe(tmp_path: Path) -> None:
    manifest = plan_dataset(with_difficulty(load_recipe("smoke"), 0.7), GenerateConfig(scenes=1)).manifest
    write_recipe(tmp_path / "recipe.yaml", manifest)
    assert plan_dataset(load_recipe(str(tmp_path / "recipe.yaml")), GenerateConfig(scenes=1)).manifest == manifest


def test_shipped_recipes_name_nothing_of_others() -> None:
    licences = plan_dataset(load_recipe("smoke"), GenerateConfig(scenes=1)).manifest.licences
    assert licences == {"data": "Apache-2.0", "textures": "Apache-2.0"}
    assert texture_licence() == "Apache-2.0"


def test_files_of_users_are_named() -> None:
    recipe = {"scene": {"traffic": {"objects": ["own/trolley.yaml"]}, "loads": {"goods": {"crate.YAML": 0.5}}}}
    licences = recipe_licences(recipe, ["flat-rays"])
    assert {name for name, text in licences.items() if text == OWNERS} == {
        "own/trolley.yaml", "crate.YAML", "plug-in flat-rays"
    }  # fmt: skip
