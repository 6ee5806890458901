"""``bench`` goes on where one of its entries cannot be scored."""

from dataclasses import replace
from pathlib import Path

import pytest
import yaml

from tests.benchmark.made import shrunk
from warehouse_sim.benchmark.result import read_result
from warehouse_sim.benchmark.suite import load_suite
from warehouse_sim.cli.main import main
from warehouse_sim.config import to_mapping

pytestmark = pytest.mark.gl
MINE = """
from warehouse_sim import PoseEstimate


class Silent:
    def estimate(self, image):
        return []


class Failing:
    def estimate(self, image):
        return 1 / 0
"""


def test_bad_entries_are_listed_and_the_rest_is_scored(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    suite = replace(shrunk(load_suite("lighting")), name="tiny", detectors=(), simulate=False)
    (tmp_path / "tiny.yaml").write_text(yaml.safe_dump(to_mapping(suite)), encoding="utf-8")
    (tmp_path / "my.py").write_text(MINE, encoding="utf-8")
    (tmp_path / "broken.csv").write_text("scene_id,im_id\n1,2,3\n", encoding="utf-8")
    (tmp_path / "other.csv").write_text(
        "scene_id,im_id,obj_id,score,R,t,time\n99,0,1,1.0,1 0 0 0 1 0 0 0 1,0 0 1000,-1\n", encoding="utf-8"
    )
    bad = ["broken.csv", "gone.csv", "other.csv", "my.py:Failing", "my.py:Silnt", "gone.py:Mine"]
    places = [str(tmp_path / name) for name in ["my.py:Silent", *bad]]
    command = ["bench", str(tmp_path / "tiny.yaml"), "--workers", "2", "--out", str(tmp_path / "bench")]
    assert main([*command, "--estimators", "oracle", *places]) == 1
    said = [line for line in capsys.readouterr().out.splitlines() if line.startswith("not scored: ")]
    for words in (
        "not scored: broken, ",
        "gone.csv: there is no such file",
        "not scored: other, ",
        "my.py:Failing failed on scene 0, image 0: ZeroDivisionError: division by zero",
        "(did you mean 'Silent'?)",
        "gone.py: there is no such file",
    ):
        assert any(words in line for line in said), words
    result = read_result(tmp_path / "bench" / "results" / "tiny.json")
    assert {row.estimator for row in result.rows} == {"oracle", "my.py:Silent"}
    assert all(str(tmp_path) not in item.reason for item in result.left_out)
    assert main([*command, "--estimators", "oracle", places[0]]) == 0
