"""An entry of the command line that cannot be scored is listed with its reason, and the rest goes on."""

from pathlib import Path

import pytest

from tests.benchmark.test_suites import shrunk
from warehouse_sim.benchmark.run import RunConfig, run_suite
from warehouse_sim.benchmark.suite import load_suite
from warehouse_sim.errors import WarehouseSimError

OWN = """
from warehouse_sim import PoseEstimate
class Mine:
    def estimate(self, image):
        return []
class Fails:
    def estimate(self, image):
        raise RuntimeError("out of memory")
"""


@pytest.mark.gl
def test_bad_entries_are_listed_and_the_rest_is_scored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(OWN)
    Path("bad.csv").write_text("scene_id,im_id,obj_id,score,R,t,time\n0,0,1,nan,1,2,3\n")
    names = ("oracle", "bad.csv", "mine.py:Fails", "mine.py:Nobody", "no-such-method", "mine.py:Mine")
    suite = shrunk(load_suite("industrial"))
    result = run_suite(suite, names, config=RunConfig(tmp_path / "out", workers=1))
    assert {row.estimator for row in result.rows if row.table == "scores"} == {"oracle", "mine.py:Mine"}
    reasons = {item.estimator: item.reason for item in result.left_out}
    assert reasons.keys() == {"bad", "mine.py:Fails", "mine.py:Nobody", "no-such-method"}
    assert "bad.csv" in reasons["bad"]
    assert "RuntimeError: out of memory" in reasons["mine.py:Fails"]
    assert "Nobody" in reasons["mine.py:Nobody"]


def test_a_single_bad_entry_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(WarehouseSimError, match="no-such-method"):
        run_suite(load_suite("industrial"), ("no-such-method",), config=RunConfig(tmp_path / "out", workers=1))
