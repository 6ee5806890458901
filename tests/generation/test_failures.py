"""Scenes that hang, fail or kill their worker: tried twice, named, skipped on request."""

import json
import shlex
import time
from contextlib import nullcontext
from functools import partial
from pathlib import Path

import pytest

from tests.dataset.toy import CAMERA, PALLET, make_manifest, write_scene
from tests.generation.test_executor import killed
from tests.shared import Shared, hashes
from warehouse_sim.cli.main import main
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.dataset.validate import validate
from warehouse_sim.errors import DatasetError, OutputError, SettleError, WorkerError
from warehouse_sim.generation import generate as generation
from warehouse_sim.generation.executor import Work, make_scenes

FORMATS = ("kitti", "bop", "bop_webdataset", "coco", "yolo", "ply", "pcd", "mcap")


def run(work: Work, scenes: range, workers: int, limit_s: float | None, skipped: list[int] | None) -> list[int]:
    skip = None if skipped is None else (lambda index, why: skipped.append(index))
    return sorted(index for index, _ in make_scenes(partial(nullcontext, work), 5, scenes, workers, limit_s, skip))


def hang(index: int) -> int:
    """Take a minute at scene 1, and no time else."""
    end = time.monotonic() + (60.0 if index == 1 else 0.0)
    while time.monotonic() < end:
        time.sleep(0.01)
    return index


@pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_scene_that_hangs_is_tried_twice_and_named(workers: int, caplog: pytest.LogCaptureFixture) -> None:
    with pytest.raises(WorkerError, match=r"limit of 0.2 s for a scene \(--scene-limit\)") as problem:
        run(hang, range(4), workers, 0.2, None)
    assert problem.value.scenes == (1,)
    assert caplog.text.count("scene 1 of seed 5") == caplog.text.count("the scene is regenerated") == 1


@pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_what_hangs_is_skipped_on_request(workers: int) -> None:
    skipped: list[int] = []
    assert run(hang, range(4), workers, 0.2, skipped) == [0, 2, 3]
    assert skipped == [1]


def settle_some(index: int) -> int:
    if index in (2, 5):
        raise SettleError(f"scene {index} of seed 5: object 3 toppled")
    return index


def never(index: int) -> int:
    raise SettleError(f"scene {index} of seed 5: object 3 toppled")


def full_disk(index: int) -> int:
    raise OutputError("data: cannot be written (No space left on device); free some space")


@pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_errors_and_deaths_are_skipped_too_but_not_everything(workers: int, tmp_path: Path) -> None:
    skipped: list[int] = []
    assert run(settle_some, range(7), workers, None, skipped) == [0, 1, 3, 4, 6]
    assert sorted(skipped) == [2, 5]
    with pytest.raises(WorkerError, match=r"(failed: scene \d+ of seed 5: object 3 toppled, 2 times.*){3}"):
        run(never, range(50), workers, None, [])
    with pytest.raises(OutputError, match="No space left") as problem:
        run(full_disk, range(50), workers, None, [])
    assert problem.value.scenes == ()  # It is no scene's fault.
    if workers > 1:
        skipped.clear()
        assert run(partial(killed, tmp_path, {1: 9}), range(4), workers, None, skipped) == [0, 2, 3]
        assert skipped == [1]


@pytest.mark.parametrize("formats", [FORMATS, ("bop", "linemod")])
def test_a_dataset_does_without_a_scene_in_every_format_and_takes_it_up_again(
    tmp_path: Path, formats: tuple[str, ...]
) -> None:
    whole, lacking = tmp_path / "whole", tmp_path / "lacking"
    manifest = make_manifest(5, formats=formats)
    for root in (whole, lacking):
        store = DatasetStore(root, manifest)
        store.begin([PALLET], CAMERA)
        for index in range(5):
            write_scene(store, index)
    DatasetStore(whole, manifest).finish()
    (lacking / "scenes/000001.json").unlink()  # begun, and never finished
    assert store.finish(skipped=[1]).missing == (1,)
    checks = {check.name: check for check in validate(lacking)}
    assert [check for check in checks.values() if not check.ok] == []
    assert checks["manifest"].detail.endswith("1 could not be made and are missing")
    reader = DatasetReader(lacking)
    assert {image.scene_id for split in reader.splits for image in reader.images(split)} == {0, 2, 3, 4}
    assert json.loads((lacking / "manifest.json").read_text())["missing"] == [1]
    assert "| missing | 1 of 5 scenes, which could not be made |" in (lacking / "README.md").read_text()
    there, left = hashes(whole), hashes(lacking)
    assert not any(name.startswith(("kitti/training/image_2/000002", "bop/train/000001/")) for name in left)
    store.begin([PALLET], CAMERA, resume=True)
    assert store.pending() == [1]
    write_scene(store, 1)
    if "linemod" in formats:  # It has numbered its frames through.
        with pytest.raises(DatasetError, match=r"is missing, .*; generate the dataset again"):
            store.finish()
    else:
        store.finish()
        assert hashes(lacking) == there


@pytest.mark.gl
def test_the_command_line_names_the_command_that_makes_a_failed_scene_alone(
    shared: Shared, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    prepare = generation.prepare_scene

    def fail_at_1(recipe: object, seed: int, index: int) -> object:
        if index == 1:
            raise SettleError("scene 1 of seed 0: object 3 toppled")
        return prepare(recipe, seed, index)

    monkeypatch.setattr(generation, "prepare_scene", fail_at_1)
    root = tmp_path / "data"
    command = ["generate", str(shared.bare), "--out", str(root), "--scenes", "2", "--workers", "1", "--formats", "bop"]
    assert main([*command, "--skip-failed"]) == 0
    assert json.loads((root / "manifest.json").read_text())["missing"] == [1]
    skipping = capsys.readouterr().err
    assert main([*command, "--resume"]) == 2
    rejecting = capsys.readouterr().err
    assert "error: scene 1 of seed 0: object 3 toppled" in rejecting
    assert not (root / "manifest.json").exists()
    (said,) = {line for text in (skipping, rejecting) for line in text.splitlines() if "alone: " in line}
    monkeypatch.undo()
    assert main(shlex.split(said.partition("alone: ")[2])[1:]) == 0
    assert (tmp_path / "data-scene-1/scenes/000001.json").is_file()
    assert not (tmp_path / "data-scene-1/scenes/000000.json").exists()
