import csv
import json
import struct
from dataclasses import replace
from itertools import count
from pathlib import Path
from types import SimpleNamespace

import pytest
import safetensors.torch
import torch
from tensorboardX.proto.event_pb2 import Event

from tests.dataset.toy import CAMERA, PALLET, make_manifest, write_scene
from tests.estimators.pose.densefusion.variants import renamed
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.errors import ConfigError, DatasetError, TrainingError, UnknownNameError
from warehouse_sim.estimators.pose.densefusion.crops.batch import Batch, sample_batch
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import CropSet
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import PoseRun
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
from warehouse_sim.estimators.pose.densefusion.training import train as pose_task
from warehouse_sim.estimators.pose.densefusion.training.train import rate_factor, refiner_alone
from warehouse_sim.estimators.train import train

POINTS = "densefusion-pointcloud"
SHORT = TrainConfig(max_minutes=None, max_steps=6, batch=4, validations=3, precision="32", workers=1)


@pytest.fixture(scope="module")
def finished(toy_root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return train("densefusion-pointcloud", toy_root, tmp_path_factory.mktemp("runs") / "run", SHORT)


def test_run_folder_is_complete_and_readable(finished: Path) -> None:
    config = PoseRun.read(finished)
    assert config.estimator == "densefusion-pointcloud"
    assert config.train == SHORT
    assert [shape.name for shape in config.objects] == ["toy-pallet"]
    rows = list(csv.DictReader((finished / "curves.csv").open()))
    assert [int(row["step"]) for row in rows] == [2, 4, 6]
    result = json.loads((finished / "result.json").read_text())
    assert result["steps"] == 6
    assert result["samples"] == 24
    assert result["precision"] == "32-true"
    assert result["val_median_mm"] == float(rows[-1]["val_median_mm"])


def test_steps_may_see_fewer_points_than_prediction(
    toy_root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: dict[bool, set[int]] = {True: set(), False: set()}

    def spied(
        crops: CropSet, index: torch.Tensor, count: int, generator: object, augment: object, *more: object
    ) -> Batch:
        batch = sample_batch(crops, index, count, generator, augment, *more)  # type: ignore[arg-type]
        seen[augment is not None].add(batch.inputs.points.shape[1])
        return batch

    monkeypatch.setattr(pose_task, "sample_batch", spied)
    run = train(POINTS, toy_root, tmp_path / "run", replace(SHORT, points=24))
    assert seen == {True: {24}, False: {PoseRun.read(run).network.points.count}}


def read_events(folder: Path) -> dict[str, list[tuple[int, float]]]:
    """Read TensorBoard's records: length, its checksum, an event, its checksum."""
    values: dict[str, list[tuple[int, float]]] = {}
    for path in sorted(folder.glob("events.out.tfevents.*")):
        data = path.read_bytes()
        while data:
            (length,) = struct.unpack("<Q", data[:8])
            event = Event.FromString(data[12 : 12 + length])
            for value in event.summary.value:
                values.setdefault(value.tag, []).append((event.step, value.simple_value))
            data = data[16 + length :]
    return values


def test_events_hold_the_same_curves(finished: Path) -> None:
    rows = list(csv.DictReader((finished / "curves.csv").open()))
    events = read_events(finished / "tensorboard")
    assert [step for step, _ in events["val/median_mm"]] == [2, 4, 6]
    found = [value for _, value in events["val/median_mm"]]
    assert found == pytest.approx([float(row["val_median_mm"]) for row in rows], abs=1e-3)
    assert [step for step, _ in events["train/loss"]] == [step for step, _ in events["train/learning_rate"]] == [1]


class KilledError(Exception):
    pass


def test_a_killed_run_resumes_to_the_same_weights(toy_root: Path, tmp_path: Path, finished: Path) -> None:
    def kill(fraction: float, note: str) -> None:
        if note.startswith("step 5"):
            raise KilledError

    run = tmp_path / "run"
    with pytest.raises(KilledError):
        train("densefusion-pointcloud", toy_root, run, SHORT, progress=kill)
    assert not (run / "weights.safetensors").exists()
    steps = []
    train("densefusion-pointcloud", toy_root, run, SHORT, resume=True, progress=lambda _, note: steps.append(note))
    # The last checkpoint was written after step 4.
    assert [note.split(",")[0] for note in steps if note.startswith("step")] == ["step 5", "step 6"]
    expected, found = (safetensors.torch.load_file(path / "weights.safetensors") for path in (finished, run))
    assert expected.keys() == found.keys()
    for name, value in expected.items():
        assert torch.equal(found[name], value), name
    assert [row["step"] for row in csv.DictReader((run / "curves.csv").open())] == ["2", "4", "6"]
    events = [line.split("Z  ")[1].split(" ")[0] for line in (run / "train.log").read_text().splitlines()]
    assert (events[0], events[-1]) == ("train", "done:")
    assert events.count("resume") == 1


def weights(run: Path) -> dict[str, torch.Tensor]:
    return safetensors.torch.load_file(run / "weights.safetensors")


def test_crops_are_read_from_the_images_once(toy_root: Path, tmp_path: Path) -> None:
    notes: list[str] = []

    def reads(name: str, cache: Path) -> bool:
        notes.clear()
        train(POINTS, toy_root, tmp_path / name, SHORT, progress=lambda _, note: notes.append(note), cache=cache)
        return any(note.startswith("reading train of data") for note in notes)

    assert reads("first", tmp_path / "kept")
    assert not reads("second", tmp_path / "kept")
    assert reads("memory", Path("none"))
    first, second, memory = (weights(tmp_path / name) for name in ("first", "second", "memory"))
    assert all(torch.equal(first[name], second[name]) and torch.equal(first[name], memory[name]) for name in first)


def test_the_run_folder_has_the_averaged_weights(toy_root: Path, tmp_path: Path, finished: Path) -> None:
    last = weights(train(POINTS, toy_root, tmp_path / "last", replace(SHORT, ema=0.0)))
    averaged = weights(finished)
    (checkpoint,) = (finished / "checkpoints").iterdir()
    trained = safetensors.torch.load_file(checkpoint)
    for name in averaged:
        torch.testing.assert_close(trained[f"network.{name}"], last[name], msg=name)
    assert any(not torch.allclose(averaged[name], last[name], atol=1e-4) for name in averaged)


def test_several_datasets_are_trained_on_together(toy_root: Path, tmp_path: Path, finished: Path) -> None:
    cartons = renamed(toy_root, tmp_path / "cartons", 7, "toy-carton", "carton")
    run = train(POINTS, [toy_root, cartons], tmp_path / "run", SHORT)
    config = PoseRun.read(run)
    assert [shape.name for shape in config.objects] == ["toy-pallet", "toy-carton"]
    assert [source.name for source in config.datasets] == ["data", "cartons"]
    one, both = (json.loads((folder / "result.json").read_text()) for folder in (finished, run))
    assert both["train_crops"] == 2 * one["train_crops"]
    assert both["val_crops"] == 2 * one["val_crops"]


def test_training_begins_with_given_weights(toy_root: Path, tmp_path: Path, finished: Path) -> None:
    still = replace(SHORT, max_steps=1, validations=1, learning_rate=1e-9)
    run = train(POINTS, toy_root, tmp_path / "run", still, init=str(finished))
    assert PoseRun.read(run).started_from.name == str(finished)
    for name, value in weights(finished).items():
        torch.testing.assert_close(weights(run)[name], value, msg=name)
    with pytest.raises(UnknownNameError, match="bundled name or a run folder"):
        train(POINTS, toy_root, tmp_path / "unknown", SHORT, init="densefusionn")
    with pytest.raises(TrainingError, match=r"densefusion-pointcloud, size nano, which do not fit \(other"):
        train("densefusion", toy_root, tmp_path / "other", SHORT, init=finished)


def test_time_limit_holds(toy_root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # A clock that goes on by a hundredth of a second whenever it is read, however slow the machine is.
    readings = count()
    clock = SimpleNamespace(monotonic=lambda: next(readings) / 100.0)
    for module in ("clock", "loop", "observer"):
        monkeypatch.setattr(f"warehouse_sim.learning.{module}.time", clock)
    config = replace(SHORT, max_steps=None, max_minutes=3 / 60)
    run = train("densefusion-pointcloud", toy_root, tmp_path / "run", config)
    result = json.loads((run / "result.json").read_text())
    assert 1.9 < result["seconds"] <= 3.0  # a second is kept for the files
    rows = list(csv.DictReader((run / "curves.csv").open()))
    assert float(rows[-1]["learning_rate"]) < 0.1 * config.learning_rate


def test_rejects_what_would_lose_or_mix_runs(toy_root: Path, tmp_path: Path, finished: Path) -> None:
    with pytest.raises(TrainingError, match="not empty"):
        train("densefusion-pointcloud", toy_root, finished, SHORT)
    with pytest.raises(TrainingError, match="nothing to resume"):
        train("densefusion-pointcloud", toy_root, finished, SHORT, resume=True)
    half = tmp_path / "half"
    half.mkdir()
    (half / "config.yaml").write_bytes((finished / "config.yaml").read_bytes())
    with pytest.raises(TrainingError, match="run of densefusion-pointcloud, not of densefusion"):
        train("densefusion", toy_root, half, SHORT, resume=True)
    with pytest.raises(TrainingError, match="goes on with the settings"):
        train("densefusion-pointcloud", toy_root, half, replace(SHORT, batch=5), resume=True)


def test_wrong_names_and_folders_give_one_line(toy_root: Path, tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match="known: densefusion, densefusion-depth"):
        train("densefuson", toy_root, tmp_path / "a", SHORT)
    with pytest.raises(DatasetError, match="is not a folder"):
        train("densefusion", tmp_path / "nothing", tmp_path / "b", SHORT)


def test_an_empty_split_is_named(tmp_path: Path) -> None:
    manifest = replace(make_manifest(2, ("bop",)), splits={"train": (0, 1), "val": (), "test": ()})
    store = DatasetStore(tmp_path / "data", manifest)
    store.begin([PALLET], CAMERA)
    for index in range(2):
        write_scene(store, index)
    store.finish()
    with pytest.raises(TrainingError, match="the split 'val' has no target"):
        train("densefusion-pointcloud", tmp_path / "data", tmp_path / "run", SHORT)


def test_settings_that_never_end_are_rejected() -> None:
    with pytest.raises(ConfigError, match="never ends"):
        TrainConfig(max_minutes=None, max_steps=None)


# The refiner trained alone: nothing else moves, at a learning rate of its own, and it learns.


ON_TOP = replace(SHORT, phase="refiner")


@pytest.fixture(scope="module")
def unrefined(toy_root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return train(POINTS, toy_root, tmp_path_factory.mktemp("runs") / "run", replace(SHORT, refiner_iterations=0))


def moved(before: dict[str, torch.Tensor], after: dict[str, torch.Tensor]) -> set[str]:
    return {name.split(".")[0] for name in before if not torch.equal(before[name], after[name])}


def test_a_phase_on_top_of_a_run_moves_the_refiner_alone(toy_root: Path, tmp_path: Path, unrefined: Path) -> None:
    run = train(POINTS, toy_root, tmp_path / "run", ON_TOP, init=unrefined)
    before, after = weights(unrefined), weights(run)
    assert moved(before, after) == set()
    assert {name.split(".")[0] for name in after.keys() - before.keys()} == {"refiner"}
    assert any(value.any() for name, value in after.items() if name.startswith("refiner.outputs"))
    config = PoseRun.read(run)
    assert (config.train.phase, config.started_from.name) == ("refiner", str(unrefined))


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


def test_a_phase_on_top_needs_something_below(toy_root: Path, tmp_path: Path, unrefined: Path) -> None:
    with pytest.raises(TrainingError, match="name it with --init"):
        train(POINTS, toy_root, tmp_path / "run", ON_TOP)
    cartons = renamed(toy_root, tmp_path / "cartons", 7, "toy-carton", "carton")
    with pytest.raises(TrainingError, match=r"does not know toy-carton.*--objects toy-pallet"):
        train(POINTS, [toy_root, cartons], tmp_path / "run", ON_TOP, init=unrefined)
    with pytest.raises(ConfigError, match="refiner_iterations must be 1 or more"):
        replace(ON_TOP, refiner_iterations=0)
