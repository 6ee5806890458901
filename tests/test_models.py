"""Bundled models: what their cards say comes out of their weights."""

from itertools import islice
from pathlib import Path

import numpy as np
import pytest
import safetensors.numpy

from trainings.headline import RECIPE, SCENES, SEED, headline, observations, observed
from warehouse_sim.estimators.registries import DETECTORS, SEGMENTERS, trained_names
from warehouse_sim.resources import data_folder, model_dir, model_names
from warehouse_sim.schema import Observation
from warehouse_sim.yaml_file import read_yaml

_ANY_LAYOUT = "-warehouses"
"""Ending of weights whose cards have no headline."""
MODELS = [
    name
    for name in model_names()
    if name not in (*DETECTORS.names(), *SEGMENTERS.names()) and not name.endswith(_ANY_LAYOUT)
]
LARGEST_MIB = 12.0


@pytest.fixture(scope="module")
def few() -> list[Observation]:
    return list(islice(observed(), 4))


@pytest.fixture(scope="module")
def seen() -> list[Observation]:
    return observations()


def test_every_method_is_bundled() -> None:
    assert set(MODELS) >= set(trained_names())


@pytest.mark.gl
@pytest.mark.parametrize("name", MODELS)
def test_the_weights_estimate_the_first_pallets_as_the_card_says(name: str, few: list[Observation]) -> None:
    measured = headline(model_dir(name), few)
    assert measured.count > 30
    assert measured.fraction > read_yaml(model_dir(name) / "card.yaml")["headline"]["fraction"] - 0.06


@pytest.mark.slow
@pytest.mark.gl
@pytest.mark.parametrize("name", MODELS)
def test_the_headline_of_the_card_comes_out_of_the_weights(name: str, seen: list[Observation]) -> None:
    card, measured = read_yaml(model_dir(name) / "card.yaml")["headline"], headline(model_dir(name), seen)
    assert measured.count == card["count"]
    # Another processor or driver may move a pallet or two across the limit.
    assert measured.fraction == pytest.approx(card["fraction"], abs=3 / measured.count)


@pytest.mark.parametrize("name", MODELS)
def test_a_card_has_its_headline(name: str) -> None:
    card = read_yaml(model_dir(name) / "card.yaml")["headline"]
    assert (card["recipe"], card["seed"], card["scenes"]) == (RECIPE, SEED, SCENES)
    assert f"{100 * card['fraction']:.1f} % of {card['count']} pallets" in (model_dir(name) / "card.md").read_text()


@pytest.mark.parametrize("name", MODELS)
def test_a_model_is_small_and_its_weights_are_numbers(name: str) -> None:
    folder = model_dir(name)
    assert sum(path.stat().st_size for path in folder.rglob("*")) < LARGEST_MIB * 2**20
    for value in safetensors.numpy.load_file(folder / "weights.safetensors").values():
        assert np.isfinite(value).all()


@pytest.mark.parametrize("name", MODELS)
def test_a_card_says_how_the_weights_were_made(name: str) -> None:
    text = (model_dir(name) / "card.md").read_text(encoding="utf-8")
    for word in (
        "trained on",
        "samples in",
        "seed",
        "| licence | Apache-2.0",
        "Not tested on real images",
        "### `industrial`",
        "| 7-15 m |",
    ):
        assert word in text, word


@pytest.mark.parametrize("name", MODELS)
def test_no_folder_of_a_machine_is_named(name: str) -> None:
    for path in model_dir(name).rglob("*.yaml"):
        assert "name: /" not in path.read_text(encoding="utf-8"), path


def test_the_table_names_every_model() -> None:
    text = (Path(data_folder("models")) / "README.md").read_text(encoding="utf-8")
    assert all(f"({name}/card.md)" in text for name in MODELS)
