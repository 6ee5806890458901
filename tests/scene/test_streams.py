import numpy as np
import pytest

from warehouse_sim.errors import RecipeError
from warehouse_sim.scene import scene_rng


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
