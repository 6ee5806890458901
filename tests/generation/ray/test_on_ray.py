"""A dataset that ``generate --on ray`` made on two nodes, of which one was lost, is that of one process."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.generation.test_generate import hashes
from tests.shared import Shared

pytestmark = [pytest.mark.slow, pytest.mark.gl]
pytest.importorskip("ray")
SHARDS = [f"shard-{index:06d}.tar" for index in range(4)]


def said(folder: Path, mode: str) -> tuple[dict[str, Any], str]:
    """Return what ``two_nodes.py`` found, and what the command wrote to stderr."""
    paths = os.pathsep.join(filter(None, sys.path))
    command = [sys.executable, str(Path(__file__).with_name("two_nodes.py")), str(folder), mode]
    environment = {**os.environ, "PYTHONPATH": paths}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stderr[-2000:]
    return json.loads((folder / "said.json").read_text()), done.stderr


@pytest.mark.parametrize("mode", ["file", "s3", "client"])
def test_a_cluster_that_loses_a_node_makes_the_bytes_of_one_process(tmp_path: Path, shared: Shared, mode: str) -> None:
    found, _ = said(tmp_path, mode)
    assert found["ended"] == [0, 0]
    assert found["lost_after"][0] < 4
    assert found["shards"] == SHARDS
    assert found["kept"]
    assert hashes(tmp_path / "cluster") == hashes(shared.dataset("smoke", scenes=4, seed=3))


def test_a_connection_that_is_gone_ends_the_command_with_an_error(tmp_path: Path) -> None:
    found, chatter = said(tmp_path, "gone")
    assert found["ended"][0] not in (0, -1)
    assert "the connection to the Ray cluster is gone" in chatter
    assert found["lost_after"][0] < 4
    assert not (tmp_path / "cluster").exists()
