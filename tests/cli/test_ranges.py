"""Numbers on the command line keep to the ranges of files: one line, exit code 2."""

import pytest

from warehouse_sim.cli.main import main


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["generate", "smoke", "--scenes", "0"], "scenes must be 1-1,000,000, found 0"),
        (["generate", "smoke", "--scenes", "1000000000"], "scenes must be 1-1,000,000, found 1000000000"),
        (["generate", "smoke", "--seed", "-1"], "seed must be 0-9,223,372,036,854,775,807, found -1"),
        (["generate", "smoke", "--workers", "-4"], "--workers must be at least 1, found -4"),
        (["train", "densefusion", "--data", "none", "--batch", "0"], "batch must be 1-65,536, found 0"),
        (["train", "densefusion", "--data", "none", "--learning-rate", "nan"], "learning_rate must be "),
        (["train", "densefusion", "--data", "none", "--max-minutes", "None"], "training never ends"),
        (["train", "densefusion", "--data", "none", "--augment.yaw", "inf"], "yaw must be 0-10 rad, found inf"),
        (["predict", "densefusion", "--data", "none", "--icp.points", "-1"], "points must be 12-100,000, found -1"),
    ],
)
def test_a_number_out_of_range_ends_with_one_line(arguments, message, tmp_path, capfd) -> None:
    assert main([*arguments, "--out", str(tmp_path / "out")]) == 2
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith(f"error: {message}")
    assert not (tmp_path / "out").exists()
