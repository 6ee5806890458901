from pathlib import Path
from typing import Any

import numpy as np
import pytest

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
