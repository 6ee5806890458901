"""What predict says of itself beside its file: the command line that gives the same predictions."""

import shlex
from pathlib import Path

from warehouse_sim.cli.commands.predict import _command
from warehouse_sim.estimators.settings import PredictConfig


def test_defaults_are_left_out_and_all_else_is_there() -> None:
    plain = _command("front-fit", None, Path("my data"), Path("p.csv"), "test", PredictConfig())
    assert shlex.split(plain) == [
        *("warehouse-sim", "predict", "front-fit", "--data", "my data", "--out", "p.csv", "--split", "test")
    ]
    config = PredictConfig(refine="icp", uncertainty=False, objects=("epal1", "epal6"), track=True)
    words = shlex.split(_command(None, "prog --x", Path("d"), Path("p.csv"), "val", config))
    assert words[2:4] == ["--exec", "prog --x"]
    assert words[10:] == ["--objects", "epal1", "epal6", "--refine", "icp", "--no-uncertainty", "--track"]
