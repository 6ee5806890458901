"""A sample of the hostile cases: none ends in a traceback, a crash, a hang or silent nonsense."""

from pathlib import Path

import pytest

from benchmarks.acceptance.hostile.__main__ import main


@pytest.mark.slow
@pytest.mark.gl
def test_a_sample_of_hostile_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code = main(cases=120, seed=1, out=tmp_path / "result.json")
    assert code == 0, capsys.readouterr().out
