"""Other people's tools open what we wrote, each in a process of an environment that holds no line of ours."""

import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

RunTool = Callable[..., str]
TOOLS = Path(__file__).parent / "tools"


@pytest.fixture(scope="session")
def run_tool() -> RunTool:
    """Run a script of ``tools/`` with the tools' Python and return what it prints; it must end well."""
    python = os.environ.get("WAREHOUSE_SIM_ECOSYSTEM")
    if not python or not Path(python).exists():
        pytest.skip("WAREHOUSE_SIM_ECOSYSTEM names no Python with the tools; `make test-ecosystem` makes one")

    def run(script: str, *arguments: object, timeout: float = 300.0) -> str:
        command = [str(Path(python).absolute()), str(TOOLS / script), *map(str, arguments)]
        environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
        done = subprocess.run(command, capture_output=True, text=True, timeout=timeout, env=environment)
        assert done.returncode == 0, f"{script}: {done.stderr[-2000:]}"
        return done.stdout

    return run
