"""A bundled model without the objects that only training needed estimates the others as before."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from trainings import bundle
from trainings.poses import FIRST, in_order, limited
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import PoseRun
from warehouse_sim.estimators.pose.densefusion.objects import read_meshes
from warehouse_sim.estimators.pose.densefusion.training.preparation import per_object_tensors
from warehouse_sim.resources import data_folder


def test_left_out_objects_leave_the_others_their_weights(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = tmp_path / "run"
    shutil.copytree(data_folder("models") / "densefusion-depth", run)
    shutil.rmtree(run / "first_stage")
    monkeypatch.setattr(bundle, "data_folder", lambda name: tmp_path)
    model = bundle.bundle(run, "small", without="carton_*")
    old, new = PoseRun.read(run), PoseRun.read(model)
    kept = [number for number, shape in enumerate(old.objects) if not shape.name.startswith("carton_")]
    assert 0 < len(kept) < len(old.objects)
    assert [shape.name for shape in new.objects] == [old.objects[number].name for number in kept]
    assert replace(new, objects=old.objects) == old
    assert set(read_meshes(model)) == {shape.obj_id for shape in new.objects}
    before, after = old.load_network(run).state_dict(), new.load_network(model).state_dict()
    grown = per_object_tensors(old.network)
    assert grown
    for name, value in after.items():
        expected = before[name][kept] if name in grown else before[name]
        np.testing.assert_array_equal(value.numpy(), expected.numpy())
    assert torch.is_tensor(after[next(iter(grown))])


def test_a_bundled_model_names_no_folder_of_a_machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = tmp_path / "run"
    shutil.copytree(data_folder("models") / "densefusion-depth", run)
    config = PoseRun.read(run)
    assert config.started_from is not None
    before = replace(config.started_from, name="/home/somebody/runs/first/densefusion-depth")
    replace(config, started_from=before).write(run)
    monkeypatch.setattr(bundle, "data_folder", lambda name: tmp_path)
    after = PoseRun.read(bundle.bundle(run, "small"))
    assert after.started_from == replace(before, name="first/densefusion-depth")
    assert replace(after, started_from=config.started_from) == config
    first = tmp_path / "first"
    shutil.copytree(run, first)
    shutil.rmtree(first / bundle.FIRST_STAGE, ignore_errors=True)
    shutil.copytree(run, first / bundle.FIRST_STAGE)
    stages = list(bundle.bundle(run, "small", first).rglob("config.yaml"))
    assert len(stages) >= 3
    assert not any("somebody" in file.read_text(encoding="utf-8") for file in stages)


def test_the_cheap_methods_are_trained_first_and_time_is_shared() -> None:
    assert in_order(["densefusion", "densefusion-pointcloud", "densefusion-depth"])[:2] == [
        "densefusion-depth",
        "densefusion-pointcloud",
    ]
    assert limited(FIRST, 60.0, 0.5).max_minutes == 30.0
    assert limited(FIRST, None, 0.5, steps=7).max_minutes is None
    assert limited(FIRST, None, 0.5, steps=7).max_steps == 7
