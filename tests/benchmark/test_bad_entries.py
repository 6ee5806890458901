"""``bench`` lists an entry of its command line that cannot be scored with the reason, and the rest goes on."""

from dataclasses import replace
from pathlib import Path

import pytest
import yaml

from tests.benchmark.made import bench_folder, only_scored
from tests.shared import Shared
from warehouse_sim.benchmark.result import read_result
from warehouse_sim.benchmark.run import RunConfig, run_suite
from warehouse_sim.benchmark.suite import load_suite
from warehouse_sim.cli.main import main
from warehouse_sim.config import to_mapping
from warehouse_sim.errors import WarehouseSimError

MINE = """
class Silent:
    def estimate(self, image):
        return []


class Failing:
    def estimate(self, image):
        return 1 / 0
"""
ROWS = "scene_id,im_id,obj_id,score,R,t,time\n"
SAID = {
    "short.csv": "not scored: short, ",
    "nan.csv": "not scored: nan, ",
    "gone.csv": "gone.csv: there is no such file",
    "other.csv": "not scored: other, ",
    "my.py:Failing": "my.py:Failing failed on scene 0, image 0: ZeroDivisionError: division by zero",
    "my.py:Silnt": "(did you mean 'Silent'?)",
    "gone.py:Mine": "gone.py: there is no such file",
    "no-such-method": "no-such-method",
}


@pytest.mark.gl
def test_bad_entries_are_listed_and_the_rest_is_scored(
    shared: Shared, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    suite = only_scored(load_suite("lighting"))
    suite = replace(suite, conditions=dict([*suite.evaluated.items()][:1]), compare=(), name="tiny")
    Path("tiny.yaml").write_text(yaml.safe_dump(to_mapping(suite)), encoding="utf-8")
    Path("my.py").write_text(MINE)
    Path("short.csv").write_text("scene_id,im_id\n1,2,3\n")
    Path("nan.csv").write_text(f"{ROWS}0,0,1,nan,1 0 0 0 1 0 0 0 1,0 0 1000,-1\n")
    Path("other.csv").write_text(f"{ROWS}99,0,1,1.0,1 0 0 0 1 0 0 0 1,0 0 1000,-1\n")
    out = bench_folder(shared, tmp_path / "bench")
    command = ["bench", "tiny.yaml", "--workers", "1", "--out", str(out), "--estimators", "oracle", "my.py:Silent"]
    assert main([*command, *SAID]) == 1
    said = [line for line in capsys.readouterr().out.splitlines() if line.startswith("not scored: ")]
    assert len(said) >= len(SAID)
    for words in SAID.values():
        assert any(words in line for line in said), words
    result = read_result(out / "results" / "tiny.json")
    assert {row.estimator for row in result.rows} == {"oracle", "my.py:Silent"}
    assert all(str(tmp_path) not in item.reason for item in result.left_out)
    assert main(command) == 0


def test_a_single_bad_entry_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(WarehouseSimError, match="no-such-method"):
        run_suite(load_suite("industrial"), ("no-such-method",), config=RunConfig(tmp_path / "out", workers=1))
