"""The refiner trained alone: nothing else moves, at a learning rate of its own, and it learns."""

from dataclasses import replace
from pathlib import Path

import pytest
import safetensors.torch
import torch

from tests.estimators.pose.densefusion.training.test_train import POINTS, SHORT, weights
from tests.estimators.pose.densefusion.variants import renamed
from warehouse_sim.errors import ConfigError, TrainingError
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import PoseRun
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
from warehouse_sim.estimators.pose.densefusion.training.train import rate_factor, refiner_alone
from warehouse_sim.estimators.train import train

ON_TOP = replace(SHORT, phase="refiner")


@pytest.fixture(scope="module")
def finished(toy_root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return train(POINTS, toy_root, tmp_path_factory.mktemp("runs") / "run", replace(SHORT, refiner_iterations=0))


def moved(before: dict[str, torch.Tensor], after: dict[str, torch.Tensor]) -> set[str]:
    return {name.split(".")[0] for name in before if not torch.equal(before[name], after[name])}


def test_a_phase_on_top_of_a_run_moves_the_refiner_alone(toy_root: Path, tmp_path: Path, finished: Path) -> None:
    run = train(POINTS, toy_root, tmp_path / "run", ON_TOP, init=finished)
    assert moved(weights(finished), weights(run)) == {"refiner"}
    config = PoseRun.read(run)
    assert (config.train.phase, config.started_from.name) == ("refiner", str(finished))


def test_apart_leaves_the_rest_as_it_is_from_where_the_refiner_begins(toy_root: Path, tmp_path: Path) -> None:
    config = replace(SHORT, phase="apart", refiner_start=0.5, ema=0.0, validations=2)
    between: list[dict[str, torch.Tensor]] = []

    def keep(part: float, note: str) -> None:
        if note.startswith("step 4") and not between:
            (checkpoint,) = (tmp_path / "run" / "checkpoints").iterdir()
            stored = safetensors.torch.load_file(checkpoint)
            names = (name for name in stored if name.startswith("network."))
            between.append({name.removeprefix("network."): stored[name] for name in names})

    run = train(POINTS, toy_root, tmp_path / "run", config, progress=keep)
    assert moved(between[0], weights(run)) == {"refiner"}
    # Before that, nothing asks the refiner: its last layer is still zero.
    outputs = [value for name, value in between[0].items() if name.startswith("refiner.outputs")]
    assert outputs
    assert not any(value.any() for value in outputs)


def test_each_phase_has_a_cosine_of_its_own() -> None:
    config = TrainConfig(phase="apart", refiner_start=0.75)
    late = 10_000  # steps: no warming up
    found = [rate_factor(config, fraction, late) for fraction in (0.0, 0.375, 0.75 - 1e-9, 0.75, 0.875, 1.0)]
    assert found == pytest.approx([1.0, 0.505, 0.01, 0.3, 0.3 * 0.505, 0.003], abs=1e-6)
    assert [refiner_alone(config, fraction) for fraction in (0.0, 0.74, 0.75, 1.0)] == [False, False, True, True]
    assert refiner_alone(replace(config, phase="refiner"), 0.0)
    assert not refiner_alone(replace(config, phase="joint"), 1.0)


def test_a_phase_on_top_needs_something_below(toy_root: Path, tmp_path: Path, finished: Path) -> None:
    with pytest.raises(TrainingError, match="name it with --init"):
        train(POINTS, toy_root, tmp_path / "run", ON_TOP)
    cartons = renamed(toy_root, tmp_path / "cartons", 7, "toy-carton", "carton")
    with pytest.raises(TrainingError, match=r"does not know toy-carton.*--objects toy-pallet"):
        train(POINTS, [toy_root, cartons], tmp_path / "run", ON_TOP, init=finished)
    with pytest.raises(ConfigError, match="refiner_iterations must be 1 or more"):
        replace(ON_TOP, refiner_iterations=0)
