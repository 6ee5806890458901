import numpy as np
import pytest

from warehouse_sim.errors import RecipeError
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.scene import sampling, scene_rng


def first(*key: object) -> float:
    return float(scene_rng(*key).random())  # type: ignore[arg-type]


def test_a_stream_depends_on_all_of_its_key_and_on_nothing_else() -> None:
    np.random.seed(3)  # noqa: NPY002  the global state must not matter
    draws = [
        first(0, 0, "loads"),
        first(1, 0, "loads"),
        first(0, 1, "loads"),
        first(0, 0, "lights"),
        first(0, 0, "loads", 1),
    ]
    assert len(set(draws)) == 5
    assert first(0, 0, "loads") == draws[0]
    assert first(0, 0, "loads", 0) == draws[0]


@pytest.mark.parametrize("key", [(-1, 0, "a"), (0, -1, "a"), (0, 0, "a", -1)])
def test_negative_numbers_are_rejected(key: tuple[object, ...]) -> None:
    with pytest.raises(RecipeError, match="must be >= 0, found -1"):
        first(*key)


def test_no_two_stages_of_a_scene_share_a_stream(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []

    def recorded(seed: int, index: int, stage: str, *more: int) -> np.random.Generator:
        asked.append(stage)
        return scene_rng(seed, index, stage, *more)

    monkeypatch.setattr(sampling, "scene_rng", recorded)
    sampling.sample_scene(load_recipe("smoke").scene, 0, 0)
    assert "staging" in asked
    assert "lanes" in asked
    assert len(set(asked)) == len(asked)
