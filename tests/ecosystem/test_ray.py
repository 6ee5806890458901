"""A dataset that a real Ray cluster made, though it lost a node, is that of one process."""

import json
from pathlib import Path

import pytest

from tests.ecosystem.conftest import RunTool
from tests.generation.test_generate import hashes

pytestmark = [pytest.mark.ecosystem, pytest.mark.gl]


@pytest.mark.parametrize("place", ["file", "s3"])
def test_a_cluster_that_loses_a_node_makes_the_bytes_of_one_process(
    run_tool: RunTool, tmp_path: Path, place: str
) -> None:
    printed = run_tool("ray_nodes.py", tmp_path, Path(__file__).parents[2], place, timeout=580.0)
    said = json.loads(printed.splitlines()[-1])
    assert said["nodes"] == 2
    assert said["left"] == 1
    assert said["lost_after"][0] < 4
    assert said["shards"] == [f"shard-{index:06d}.tar" for index in range(4)]
    assert said["kept"]
    assert hashes(tmp_path / "cluster") == hashes(tmp_path / "serial")
