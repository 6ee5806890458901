"""What ``--overwrite`` removes, and what it leaves when the rest of the command is wrong."""

from pathlib import Path

import pytest

from tests.dataset.toy import make_dataset
from warehouse_sim.cli.main import main


@pytest.fixture
def data(tmp_path: Path) -> Path:
    return make_dataset(tmp_path / "data")


def test_a_wrong_command_removes_nothing(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = sorted(data.rglob("*"))
    bad = tmp_path / "bad.yaml"
    bad.write_text("extends: smoke\ndescription: x\nscene: {staging: {count: 900}}\n")
    again = ["--out", str(data), "--overwrite"]
    for words in (
        ["generate", "smoek", *again],
        ["generate", str(bad), *again],
        ["generate", "smoke", *again, "--formats", "bopp"],
        ["generate", "smoke", *again, "--backend", "rastr"],
        ["generate", "smoke", *again, "--workers", "0"],
        ["generate", "smoke", *again, "--scenes", "0"],
        ["generate", "smoke", *again, "--shard", "4/2"],
        ["generate", "--merge", str(tmp_path / "none"), *again],
        ["convert", str(tmp_path / "none"), "--to", "coco", *again],
        ["convert", str(data), "--to", "yollo", "--out", str(data), "--overwrite"],
    ):
        assert main(words) == 2
        assert sorted(data.rglob("*")) == before, words
    capsys.readouterr()
    assert main(["convert", str(data), "--to", "coco", "--out", str(data), "--overwrite"]) == 2
    assert "holds the dataset that is read" in capsys.readouterr().err
    assert sorted(data.rglob("*")) == before


def test_converting_anew_replaces_the_dataset_that_was_there(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert main(["convert", str(data), "--to", "coco", "--out", str(out)]) == 0
    assert main(["convert", str(data), "--to", "yolo", "--out", str(out)]) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert main(["convert", str(data), "--to", "yolo", "--out", str(out), "--overwrite"]) == 0
    assert (out / "yolo").is_dir()
    assert not (out / "coco").exists()


def test_only_datasets_are_overwritten(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    letters = tmp_path / "letters"
    letters.mkdir()
    (letters / "dear.txt").write_text("precious")
    assert main(["convert", str(data), "--to", "coco", "--out", str(letters), "--overwrite"]) == 2
    assert "holds no dataset" in capsys.readouterr().err
    assert (letters / "dear.txt").read_text() == "precious"
