"""The commands about trained estimators, on the toy dataset."""

import json
from pathlib import Path

import pytest

from tests.dataset.toy import make_dataset
from tests.estimators.pose.densefusion.made_run import made_run
from warehouse_sim.cli.main import main
from warehouse_sim.dataset.results import pose_csv


@pytest.fixture(scope="module")
def toy_root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_dataset(tmp_path_factory.mktemp("toy-cli") / "data")


def test_predict_writes_strict_bop_rows(toy_root: Path, tmp_path: Path) -> None:
    out = tmp_path / "predictions.csv"
    command = ["predict", str(made_run(tmp_path / "run")), "--data", str(toy_root), "--out", str(out)]
    assert main([*command, "--split", "train", "--selection", "weighted-50", "--refine", "icp"]) == 0
    header, *rows = out.read_text().splitlines()
    assert header == "scene_id,im_id,obj_id,score,R,t,time"
    assert all(len(row.split(",")) == 7 for row in rows)
    assert len(pose_csv.read(out)) == len(rows) > 0


def test_training_leaves_a_run_that_predicts_with_icp_and_without_the_dataset_meshes(
    toy_root: Path, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    run = tmp_path / "run"
    command = ["train", "densefusion-pointcloud", "--data", str(toy_root), "--out", str(run), "--cache", "none"]
    assert main([*command, "--max-steps", "4", "--batch", "4", "--validations", "1"]) == 0
    assert "too few objects" in capsys.readouterr().err
    assert json.loads((run / "result.json").read_text())["steps"] == 4
    assert (run / "objects.safetensors").is_file()
    assert (run / "calibration.yaml").is_file()
    out = tmp_path / "predictions.csv"
    assert main(["predict", str(run), "--data", str(toy_root), "--out", str(out), "--refine", "icp"]) == 0


@pytest.mark.slow
def test_export_writes_an_onnx_file(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    pytest.importorskip("onnxscript")
    out = tmp_path / "model.onnx"
    assert main(["export", str(made_run(tmp_path / "run")), "--out", str(out)]) == 0
    assert out.stat().st_size > 100_000
    assert "to within" in capsys.readouterr().err
