"""What several processes make before it is requested is what one would make, and is counted as made now."""

from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.benchmark.made import bench_folder, of_two_conditions, only_scored
from tests.dataset.toy import make_dataset
from tests.shared import Shared
from warehouse_sim.benchmark import ahead
from warehouse_sim.benchmark.ahead import make_ahead
from warehouse_sim.benchmark.entrants.trained import trained, trainings_of
from warehouse_sim.benchmark.run import RunConfig, run_suite
from warehouse_sim.benchmark.suite import TrainingConfig, load_suite
from warehouse_sim.errors import TrainingError
from warehouse_sim.generation.executor import make_scenes

WHO = ("shuffled",)


@dataclass(frozen=True)
class File:
    """A task that writes a file, or cannot."""

    path: Path
    problem: Exception | None = None

    @property
    def is_made(self) -> bool:
        """Whether the file is there."""
        return self.path.is_file()

    def make(self) -> object:
        """Write it."""
        if self.problem is not None:
            raise self.problem
        return self.path.write_text("made")


def test_what_cannot_be_made_is_left_and_all_else_is_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ahead, "make_scenes", lambda opens, first, left, _: make_scenes(opens, first, left, 1))
    problems = {1: TrainingError("there is nothing to write"), 4: ValueError("a plug-in errs")}
    tasks = [File(tmp_path / str(number), problems.get(number)) for number in range(5)]
    tasks[2].make()
    seen: list[tuple[int, int]] = []
    assert make_ahead(tasks, 2, lambda done, total: seen.append((done, total))) == {0, 3}
    assert seen == [(number, 4) for number in range(1, 5)]
    assert sorted(item.name for item in tmp_path.iterdir()) == ["0", "2", "3"]


@pytest.mark.slow
def test_networks_are_trained_as_a_suite_trains_them(tmp_path: Path) -> None:
    training = TrainingConfig("densefusion-pointcloud", ("toy",), (2, 4), (0,), {"batch": 4})
    data, out = {"toy": make_dataset(tmp_path / "data")}, tmp_path / "out"
    assert make_ahead(list(trainings_of("cloud", training, data, out)), 2) == {0, 1}
    groups = list(trained("cloud", training, data, out))
    assert [group.name for group in groups] == ["cloud@2", "cloud@4"]
    list(trained("cloud", training, data, tmp_path / "alone"))
    assert _weights(out) == _weights(tmp_path / "alone")


def test_one_process_or_one_task_is_not_worth_it(tmp_path: Path) -> None:
    tasks = [File(tmp_path / "a"), File(tmp_path / "b")]
    assert make_ahead(tasks, 1) == make_ahead(tasks[:1], 2) == set()
    assert not list(tmp_path.iterdir())


@pytest.mark.gl
def test_two_processes_find_the_rows_of_one(shared: Shared, tmp_path: Path) -> None:
    suite = of_two_conditions(only_scored(load_suite("industrial")))
    bench_folder(shared, tmp_path)
    alone = run_suite(suite, WHO, config=RunConfig(tmp_path, workers=1))
    overwrite = run_suite(suite, WHO, config=RunConfig(tmp_path, workers=2, overwrite=True))
    kept = run_suite(suite, WHO, config=RunConfig(tmp_path, workers=2))
    assert alone.rows == overwrite.rows == kept.rows
    assert (alone.reused, overwrite.reused, kept.reused) == (0, 0, len(WHO) * len(suite.evaluated))


def _weights(out: Path) -> dict[str, bytes]:
    found = {path.parent.name: path.read_bytes() for path in (out / "runs").glob("*/weights.safetensors")}
    assert len(found) == 2
    return found
