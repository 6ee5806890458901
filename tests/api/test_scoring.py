import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.errors import one_line
from warehouse_sim.api.dataset import Dataset
from warehouse_sim.api.scoring import evaluate, predict, report
from warehouse_sim.errors import DatasetError, EvaluationError, InputError, UnknownNameError, WarehouseSimError
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.schema import PoseEstimate

pytestmark = pytest.mark.gl


def nothing(image: Any) -> list[Any]:
    return []


def in_millimetres(image: RgbdImage) -> list[PoseEstimate]:
    T = np.eye(4)
    T[2, 3] = 3200.0
    return [PoseEstimate(image.scene_id, image.image_id, 1, 1.0, T)]


def ends(image: RgbdImage) -> list[PoseEstimate]:
    raise SystemExit


class Knowing:
    """An object of the shape that the documentation requires."""

    def __init__(self, oracle: Any = nothing) -> None:
        self.oracle = oracle

    def estimate(self, image: Any) -> list[Any]:
        return self.oracle(image)


def test_a_function_an_object_and_a_name_are_scored(data: Dataset, oracle: Any) -> None:
    scores = data.evaluate(oracle)
    assert scores["overall"]["metrics"]["add_10pct"] == scores.metrics["add_10pct"] == 1.0
    assert scores["dataset"]["split"] == "test"
    assert data.evaluate(Knowing(oracle)).metrics == scores.metrics
    assert data.evaluate(Knowing).metrics["add_10pct"] == data.evaluate(nothing).metrics["add_10pct"] == 0.0
    assert 0.0 < data.evaluate("front-fit").metrics["add_10pct"] <= 1.0
    assert repr(scores).startswith("estimate on smoke test: 6 of 6 objects found in 2 images")


def test_a_part_of_a_dataset_is_scored_alone(data: Dataset, oracle: Any) -> None:
    assert data.evaluate(oracle, split="all").counts["images"] == 6
    assert data.split("train").evaluate(oracle).dataset["split"] == "train"
    assert data[:1].evaluate(oracle).counts["images"] == 1
    assert data[:4].evaluate(oracle).counts["images"] == 4  # of train and val: test is empty


def test_files_and_lists_give_the_same_scores(data: Dataset, smoke: Path, tmp_path: Path) -> None:
    estimates = predict("rectangle-fit", str(smoke), str(tmp_path / "own_test.csv"), seed=1)
    of_file = evaluate(str(tmp_path / "own_test.csv"), str(smoke), out=str(tmp_path / "scores"))
    of_list = evaluate(estimates, data, method="rectangle-fit")
    stored = json.loads((tmp_path / "scores" / "scores.json").read_text())
    assert of_file["method"] == of_list["method"] == stored["method"] == "rectangle-fit"
    assert of_list.metrics == pytest.approx(of_file.metrics, nan_ok=True, abs=1e-4)
    assert stored["overall"]["metrics"]["add_10pct"] == of_file["overall"]["metrics"]["add_10pct"]


def test_a_report_takes_datasets_scores_and_folders(data: Dataset, oracle: Any, tmp_path: Path) -> None:
    scores = data.evaluate(oracle, out=tmp_path / "scores")
    both = report(data, scores, out=tmp_path / "both.html")
    folders = report(str(data.path), str(tmp_path / "scores"), out=str(tmp_path / "folders.html"))
    assert both == tmp_path / "both.html"
    assert both.read_text().startswith("<!doctype html>")
    assert len(both.read_text()) == pytest.approx(len(folders.read_text()), rel=0.01)


@pytest.mark.parametrize(
    ("call", "kind", "words"),
    [
        (lambda data: data.evaluate(), InputError, "missing a required argument: 'estimator'"),
        (lambda data: data.evaluate(3), WarehouseSimError, "found 3"),
        (lambda data: data.evaluate("front-ft"), UnknownNameError, "'front-ft'"),
        (lambda data: data.evaluate(lambda image: None), InputError, "must be a list of PoseEstimate, found None"),
        (lambda data: data.evaluate(lambda image: [3]), InputError, "estimate 0: must be a PoseEstimate, found 3"),
        (lambda data: data.evaluate(lambda image: 1 / 0), WarehouseSimError, "ZeroDivisionError"),
        (lambda data: data.evaluate(ends), WarehouseSimError, "SystemExit"),
        (lambda data: data.evaluate(in_millimetres), WarehouseSimError, "give metres"),
        (lambda data: RgbdImage.from_arrays(np.full((4, 4), 900.0), np.eye(3)), WarehouseSimError, "metres"),
        (lambda data: data.evaluate(nothing, split="tset"), DatasetError, "did you mean 'test'?"),
        (lambda data: data[:2].evaluate(nothing, split="test"), WarehouseSimError, "'test' has no images; train has"),
        (lambda data: evaluate([], data[:2], split="test"), EvaluationError, "has no images; choose another, or all"),
        (lambda data: data[:0].evaluate(nothing), DatasetError, "no observation to look at"),
        (lambda data: data.evaluate("front-fit", refin="icp"), WarehouseSimError, "did you mean 'refine'?"),
        (lambda data: data.evaluate("front-fit", refine="ipc"), WarehouseSimError, "refine must be one of"),
        (lambda data: data.evaluate(nothing).__getitem__("overal"), UnknownNameError, "known: counts"),
        (lambda data: evaluate(3, data), InputError, "predictions must be text, a path or a list of PoseEstimate"),
        (lambda data: evaluate([], data, out=data.path), InputError, "is the folder of the dataset"),
        (lambda data: evaluate([3], data), InputError, "a list of PoseEstimate, found [3]"),
        (lambda data: evaluate("nowhere.csv", data), DatasetError, "nowhere.csv: cannot be read"),
        (lambda data: report(), InputError, "report needs at least one"),
        (lambda data: report(data, out="page.pdf"), InputError, "page.pdf: is written as .html or .htm"),
        (lambda data: report(data.evaluate(nothing)), EvaluationError, "give that dataset's folder too"),
        (lambda data: predict("front-fit", 3), InputError, "data must be"),
    ],
)
def test_what_cannot_be_is_said_in_one_line(
    data: Dataset, call: Callable[[Dataset], Any], kind: type[Exception], words: str
) -> None:
    with one_line(kind, words):
        call(data)


def test_an_estimate_of_another_image_is_named(data: Dataset, oracle: Any) -> None:
    estimates = predict(oracle, data, split="all")
    with pytest.raises(EvaluationError, match=r"estimate 0: scene 0 image 0 is not in split 'test'"):
        evaluate(estimates, data)
