"""The whole way on a small recipe, by the commands that a user calls."""

import json
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest

from tests.shared import Shared
from warehouse_sim.cli.main import main

pytestmark = pytest.mark.gl


def say(*commands: list[str]) -> None:
    """Run commands; each must tell where its output is."""
    for command in commands:
        with redirect_stdout(StringIO()) as said:
            assert main(command) == 0, command
        assert "output: " in said.getvalue()


@pytest.fixture(scope="module")
def data(shared: Shared, tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("whole")
    say(
        ["preview", str(shared.small), "--out", str(folder / "preview.png")],
        ["generate", str(shared.small), "--out", str(folder / "data"), "--scenes", "3", "--workers", "1"],
        ["validate", str(folder / "data")],
    )
    return str(folder / "data")


@pytest.mark.parametrize("estimator", ["densefusion-pointcloud", pytest.param("densefusion", marks=pytest.mark.slow)])
def test_recipe_to_report(data: str, tmp_path: Path, estimator: str) -> None:
    run, scores = (str(tmp_path / name) for name in ("run", "scores"))
    predictions, page = str(tmp_path / "predictions.csv"), str(tmp_path / "report.html")
    say(
        ["train", estimator, "--data", data, "--out", run, "--max-minutes", "1", "--max-steps", "12", "--batch", "8"],
        ["predict", run, "--data", data, "--out", predictions, "--refine", "icp"],
        ["evaluate", predictions, "--data", data, "--out", scores],
        ["report", data, run, scores, "--out", page],
    )
    overall = json.loads((tmp_path / "scores" / "scores.json").read_text())["overall"]
    assert 0 < overall["found_count"] <= overall["gt_count"]
    assert 0.0 <= overall["metrics"]["add_10pct"] <= overall["metrics"]["add_s_10pct"] <= 1.0
    assert "<html" in Path(page).read_text()
    assert "data:image/jpeg;base64" in Path(page).read_text()
