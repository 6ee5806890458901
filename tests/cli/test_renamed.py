"""Options under their old names are rejected in one line that names the new ones, all of which exist."""

import pytest

from warehouse_sim.cli.main import main
from warehouse_sim.cli.renamed import RENAMED


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--icp.looks", "3"], "--icp.looks is now called --icp.rounds"),
        (["--icp.squash_least=0.3"], "--icp.squash-least is now called --icp.anisotropy-least"),
        (["--icp.squash-start", "0.3"], "--icp.squash-start is now called --icp.anisotropy-start"),
        (["--icp.still", "0.01"], "--icp.still is now called --icp.step-tolerance"),
    ],
)
def test_an_old_option_is_rejected_with_its_new_name(arguments, message, capsys) -> None:
    assert main(["predict", "densefusion", "--data", "none", "--out", "none.csv", *arguments]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert message in line


def test_new_names_are_options_of_predict(capsys) -> None:
    with pytest.raises(SystemExit):
        main(["predict", "--help"])
    shown = capsys.readouterr().out
    assert all(new in shown and old not in shown for old, new in RENAMED.items())
