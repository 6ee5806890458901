import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.processes import scene_workers
from tests.shared import Shared
from warehouse_sim.api.dataset import Dataset
from warehouse_sim.api.training import load_estimator, train
from warehouse_sim.errors import DatasetError, InputError, WarehouseSimError
from warehouse_sim.estimators.image import RgbdImage

pytestmark = pytest.mark.gl


def test_a_trained_run_predicts(data: Dataset, tmp_path: Path) -> None:
    run = train("densefusion-pointcloud", data, str(tmp_path / "run"), max_steps=2, batch=2, cache="none", seed=1)
    assert run == tmp_path / "run"
    scores = data.evaluate(run)
    assert scores.counts["predictions"] == 6
    assert scores.method == "run"


def test_a_run_on_a_stream_says_what_it_waited_and_leaves_no_maker(shared: Shared, tmp_path: Path) -> None:
    data = shared.dataset(shared.bare, scenes=4, seed=0, formats=("bop",))
    stream = {"recipe": str(shared.bare), "seed": 9, "window": 4, "fresh": 0.5}
    said: list[str] = []
    run = train(
        "detector-depth", data, tmp_path / "run", max_steps=3, batch=2, validations=1, cache="none", stream=stream,
        progress=lambda fraction, note: said.append(note),
    )  # fmt: skip
    result = json.loads((run / "result.json").read_text())
    assert result["steps"] == 3
    assert result["stream_filling_seconds"] > 0.0
    assert 0.0 <= result["stream_waited_fraction"] < 1.0
    assert "observation 4 of 4 of the stream's first window" in said
    assert not any(note.startswith("reading train") for note in said)
    assert scene_workers(os.getpid()) == []


@pytest.mark.parametrize(
    ("arguments", "settings", "words"),
    [
        (("densefusion-pointcloud",), {}, "missing a required argument"),
        (("densefusion-pointclod", "out", "run"), {}, "densefusion-pointclod"),
        (("front-fit", "out", "run"), {}, "needs no training"),
        (("densefusion-pointcloud", "nowhere", "run"), {}, "nowhere: is not a folder"),
        (("densefusion-pointcloud", 3, "run"), {}, "data must be"),
        (("densefusion-pointcloud", ".", "run"), {"max_step": 2}, "did you mean 'max_steps'?"),
        (("densefusion-pointcloud", ".", "run"), {"batch": 0}, "batch must be 1-65,536"),
    ],
)
def test_what_cannot_be_trained_is_said(arguments: Any, settings: Any, words: str) -> None:
    with pytest.raises(WarehouseSimError) as caught:
        train(*arguments, **settings)
    assert words in str(caught.value)


def test_an_estimator_is_loaded_by_name_or_as_it_is() -> None:
    def own(image: Any) -> list[Any]:
        return []

    image = RgbdImage.from_arrays(np.ones((4, 4)), np.diag([5.0, 5.0, 1.0]))
    assert load_estimator(own).estimate(image) == []
    assert hasattr(load_estimator("front-fit", refine="none"), "estimate")
    with pytest.raises(WarehouseSimError):
        load_estimator(3)
    with pytest.raises((InputError, DatasetError, WarehouseSimError), match="front-ft"):
        load_estimator("front-ft")
