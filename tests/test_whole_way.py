"""The whole way on the smoke recipe, by the verbs that a user calls."""

import json
from pathlib import Path

import pytest

from warehouse_sim.cli.main import main

pytestmark = pytest.mark.gl


@pytest.mark.parametrize("estimator", ["densefusion-pointcloud", "densefusion"])
def test_recipe_to_report(tmp_path: Path, capsys, estimator) -> None:
    data, run, scores = (str(tmp_path / name) for name in ("data", "run", "scores"))
    predictions, page = str(tmp_path / "predictions.csv"), str(tmp_path / "report.html")
    for command in (
        ["preview", "smoke", "--out", str(tmp_path / "preview.png")],
        ["generate", "smoke", "--out", data, "--scenes", "4", "--workers", "1"],
        ["validate", data],
        ["train", estimator, "--data", data, "--out", run, "--max-minutes", "1", "--max-steps", "12", "--batch", "8"],
        ["predict", run, "--data", data, "--out", predictions, "--refine", "icp"],
        ["evaluate", predictions, "--data", data, "--out", scores],
        ["report", data, run, scores, "--out", page],
    ):
        assert main(command) == 0, command
        assert "output: " in capsys.readouterr().out
    overall = json.loads((tmp_path / "scores" / "scores.json").read_text())["overall"]
    assert 0 < overall["found_count"] <= overall["gt_count"]
    assert 0.0 <= overall["metrics"]["add_10pct"] <= overall["metrics"]["add_s_10pct"] <= 1.0
    assert "<html" in Path(page).read_text()
    assert "data:image/jpeg;base64" in Path(page).read_text()
