"""Networks that a suite trains are kept, have one member a seed, and are trained again only for other settings."""

from dataclasses import replace
from pathlib import Path

import pytest

from tests.benchmark.made import FREE
from tests.dataset.toy import make_dataset
from warehouse_sim.benchmark.entrants.trained import settings_of, trained
from warehouse_sim.benchmark.run import RunConfig, run_suite
from warehouse_sim.benchmark.suite import CompareConfig, ConditionConfig, DataConfig, Suite, TrainingConfig
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
    larger = replace(TRAINING, steps=(2,), seeds=(0,), settings={"batch": 8})
    (one,) = trained("cloud", larger, data, tmp_path / "out")
    assert one.name == "cloud"
    assert len(list((tmp_path / "out" / "runs").iterdir())) == 5


def test_settings_that_training_does_not_take_are_named() -> None:
    with pytest.raises(ConfigError, match="trainings: cloud: settings: bach is not a setting"):
        settings_of("cloud", replace(TRAINING, settings={"bach": 4}), 2, 0)


@pytest.mark.gl
@pytest.mark.slow
def test_a_suite_asks_what_it_trained_and_counts_trainings(tmp_path: Path) -> None:
    learn = DataConfig("smoke", 6, 2, 2, {"sensors": {"lidar": None}}, ("bop",), trained_on=True)
    suite = Suite(
        1,
        "Does a network that was hardly trained beat the baseline?",
        data={"smoke": FREE, "smoke_training": learn},
        estimators=("oracle", "shuffled", "rectangle-fit"),
        metrics=("add_10pct", "found"),
        compare=(CompareConfig("training", between=(("cloud", "rectangle-fit"),)),),
        trainings={"cloud": replace(TRAINING, data=("smoke_training",))},
        name="trained",
    )
    result = run_suite(suite, config=RunConfig(tmp_path, workers=1))
    assert {item.name: (item.trainings, item.samples) for item in result.estimators if item.trainings} == {
        "cloud@2": (2, 8),
        "cloud@4": (2, 16),
    }
    (effect,) = [row for row in result.rows if row.table == "effects" and row.metric == "add_10pct"]
    assert (effect.estimator, effect.against, effect.trainings) == ("cloud@4", "rectangle-fit", 2)
    assert effect.value < 0.0
    assert not [item for item in result.data if item.name == "smoke_training"], "what is trained on is not scored"
