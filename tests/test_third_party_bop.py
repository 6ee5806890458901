"""A third-party BOP folder, gray or without masks, goes the whole way: trained on, scored and reported."""

import json
from pathlib import Path

import pytest

from tests.dataset.formats.test_external_bop import write_folder
from warehouse_sim.cli.main import main


@pytest.mark.parametrize(("masks", "gray"), [(False, True), pytest.param(True, False, marks=pytest.mark.slow)])
def test_a_folder_of_others_is_trained_on_and_scored(tmp_path: Path, masks: bool, gray: bool) -> None:
    data = write_folder(tmp_path / "theirs", masks=masks, gray=gray)
    run, csv, scored = tmp_path / "run", tmp_path / "ours_theirs-test.csv", tmp_path / "scored"
    train = ("train", "densefusion", "--data", data, "--out", run, "--size", "nano", "--max-steps", 6, "--batch", 4)
    for command in (
        train,
        ("predict", run, "--data", data, "--out", csv, "--selection", "argmax", "--refine", "none"),
        ("evaluate", csv, "--data", data, "--out", scored),
        ("report", data, run, scored, "--out", tmp_path / "report.html"),
    ):
        assert main([str(word) for word in command]) == 0, command
    scores = json.loads((scored / "scores.json").read_text())
    assert scores["counts"]["ground_truths"] == scores["counts"]["found"] == 2
    # Six steps from the mean pose, near which the box stands: a slip of its units would put it metres away.
    assert scores["overall"]["metrics"]["median_add"] < 0.3
    assert "theirs" in (tmp_path / "report.html").read_text(encoding="utf-8")
