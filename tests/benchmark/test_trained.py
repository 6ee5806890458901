"""Networks that a suite trains are kept, have one member a seed, and are trained anew only for other settings."""

from dataclasses import replace
from pathlib import Path

import pytest

from tests.dataset.toy import make_dataset
from warehouse_sim.benchmark.suite import ConditionConfig, TrainingConfig
from warehouse_sim.benchmark.trained import settings_of, trained
from warehouse_sim.errors import ConfigError

TRAINING = TrainingConfig("densefusion-pointcloud", ("toy",), (2, 4), (0, 1), {"batch": 4})


def test_every_length_and_seed_is_trained_once(tmp_path: Path) -> None:
    data = {"toy": make_dataset(tmp_path / "data")}
    groups = list(trained("cloud", TRAINING, data, tmp_path / "out"))
    assert [(group.name, group.trainings, group.facts["samples"]) for group in groups] == [
        ("cloud@2", 2, 8),
        ("cloud@4", 2, 16),
    ]
    runs = sorted((tmp_path / "out" / "runs").iterdir())
    assert len(runs) == 4
    weights = {path: (path / "weights.safetensors").stat().st_mtime_ns for path in runs}
    again = list(trained("cloud", TRAINING, data, tmp_path / "out"))
    assert {path: (path / "weights.safetensors").stat().st_mtime_ns for path in runs} == weights
    first, other = (member.inputs(ConditionConfig("toy")) for member in groups[0].members)
    assert first["weights_sha256"] != other["weights_sha256"], "seeds differ"
    assert again[0].members[0].inputs(ConditionConfig("toy")) == first
    (one,) = trained("cloud", replace(TRAINING, steps=(2,), settings={"batch": 8}), data, tmp_path / "out")
    assert one.name == "cloud"
    assert len(list((tmp_path / "out" / "runs").iterdir())) == 6


def test_settings_that_training_does_not_take_are_named() -> None:
    with pytest.raises(ConfigError, match="trainings: cloud: settings: bach is not a setting"):
        settings_of("cloud", replace(TRAINING, settings={"bach": 4}), 2, 0)
