"""The program of docs/estimators.md finds objects, and options that change nothing of programs are named."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.cli.main import main
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results import predictions
from warehouse_sim.estimators.predict import predict

DOCUMENT = Path(__file__).parents[2] / "docs" / "estimators.md"


def test_the_documented_program_finds_every_target(toy_root: Path, tmp_path: Path) -> None:
    blocks = re.findall(r"```python\n(.*?)```", DOCUMENT.read_text(encoding="utf-8"), re.DOTALL)
    (example,) = [block for block in blocks if "sys.stdin" in block]
    assert len(example.splitlines()) <= 20
    (tmp_path / "centroid.py").write_text(example, encoding="utf-8")
    out = tmp_path / "poses.csv"
    arguments = ["predict", "--exec", f"{sys.executable} {tmp_path / 'centroid.py'}", "--data", str(toy_root)]
    assert main([*arguments, "--split", "train", "--out", str(out)]) == 0
    found, reader = predictions.read(out), DatasetReader(toy_root)
    gts = {
        (item.scene_id, item.image_id): [target.T_camera_object[:3, 3] for target in item.targets]
        for item in reader.images("train")
    }
    assert len(found) == len(predict("rectangle-fit", toy_root, "train"))
    for item in found:
        away = [np.linalg.norm(item.T_camera_object[:3, 3] - place) for place in gts[item.scene_id, item.image_id]]
        assert min(away) < 0.7


@pytest.mark.parametrize("options", [["--refine", "icp"], ["--reject", "0.1"]])
def test_options_of_networks_are_rejected(
    toy_root: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str]
) -> None:
    command = ["predict", "--exec", "cat", "--data", str(toy_root), "--out", str(tmp_path / "p.csv"), *options]
    assert main(command) == 2
    assert options[0] in capsys.readouterr().err
