"""Blocks of tutorials that need a package of the tools' environment run there."""

from pathlib import Path

import pytest

from tests.ecosystem.conftest import RunTool
from warehouse_sim.dataset.validate import validate

pytestmark = [pytest.mark.ecosystem, pytest.mark.gl]


def test_the_tutorial_on_many_machines_makes_a_dataset_with_ray(
    run_tool: RunTool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    run_tool("run_tutorial.py", Path(__file__).parents[2], "08_many_machines.md", "ray", timeout=580.0)
    assert all(check.ok for check in validate(tmp_path / "out" / "from_ray"))
