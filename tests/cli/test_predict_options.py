"""Options of ``predict`` that protect files, find images and change nothing of an estimator."""

from pathlib import Path

import pytest

from tests.dataset.toy import make_dataset
from tests.estimators.pose.densefusion.made_run import made_run
from warehouse_sim.cli.main import main
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results import predictions
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.settings import PredictConfig


@pytest.fixture(scope="module")
def toy_root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_dataset(tmp_path_factory.mktemp("toy-predict") / "data")


def test_an_existing_csv_is_kept_unless_told_otherwise(
    toy_root: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "poses.csv"
    out.write_text("precious", encoding="utf-8")
    command = ["predict", "rectangle-fit", "--data", str(toy_root), "--out", str(out), "--split", "train"]
    assert main(command) == 2
    assert "add --overwrite" in capsys.readouterr().err
    assert out.read_text(encoding="utf-8") == "precious"
    assert main([*command, "--overwrite"]) == 0
    assert predictions.read(out)


def test_all_splits_are_predicted(toy_root: Path, tmp_path: Path) -> None:
    out = tmp_path / "poses.csv"
    assert main(["predict", "rectangle-fit", "--data", str(toy_root), "--out", str(out), "--split", "all"]) == 0
    scenes = {image.scene_id for image in DatasetReader(toy_root).images("all") if image.targets}
    assert len({item.scene_id for item in predictions.read(out)}) > 1
    assert {item.scene_id for item in predictions.read(out)} <= scenes


def test_a_split_without_images_names_those_with_images(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    root = make_dataset(tmp_path / "data")
    images = DatasetReader.images
    monkeypatch.setattr(DatasetReader, "images", lambda self, split: [] if split == "test" else images(self, split))
    assert main(["predict", "rectangle-fit", "--data", str(root), "--out", str(tmp_path / "p.csv")]) == 2
    said = capsys.readouterr().err
    assert "the split 'test' has no images; train and val have some" in said
    assert "--split all" in said


def test_a_gpu_that_is_not_there_is_said(
    toy_root: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("torch.cuda.is_available", lambda: False)
    run = made_run(tmp_path / "run")
    command = ["predict", str(run), "--data", str(toy_root), "--out", str(tmp_path / "p.csv"), "--device", "cuda"]
    assert main(command) == 2
    assert "error: device cuda: PyTorch finds no GPU" in capsys.readouterr().err


def test_a_folder_in_the_place_of_the_csv_is_said_before_the_work(
    toy_root: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["predict", "rectangle-fit", "--data", str(toy_root), "--out", str(tmp_path), "--split", "all"]) == 2
    err = capsys.readouterr().err
    assert "cannot be written (it is a folder)" in err
    assert "predicting" not in err


def test_the_best_settings_are_the_defaults(tmp_path: Path) -> None:
    run = made_run(tmp_path / "run")
    config = load_estimator(run).config
    assert (config.selection, config.refine) == ("consensus", "verify")
    chosen = load_estimator(run, PredictConfig(selection="argmax", refine="none")).config
    assert (chosen.selection, chosen.refine) == ("argmax", "none")
    (run / "objects.safetensors").unlink()
    assert load_estimator(run).config.refine == "none"
