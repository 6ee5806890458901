"""The jobs that docs/clusters.md shows, run as their schedulers run them: merged, the bytes of one run."""

import os
import re
import subprocess
from pathlib import Path

import pytest
import yaml

from tests.shared import Shared, hashes
from warehouse_sim.cli.main import main

pytestmark = pytest.mark.gl

DOCS = Path(__file__).parents[2] / "docs" / "clusters.md"


def block(language: str) -> str:
    found = re.findall(rf"```{language}\n(.*?)```", DOCS.read_text(), re.DOTALL)
    assert len(found) == 1
    return found[0]


@pytest.fixture(scope="module")
def environment(shared: Shared, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """An environment in which ``warehouse-sim`` writes down its arguments, a line each."""
    folder = tmp_path_factory.mktemp("bin")
    command = folder / "warehouse-sim"
    command.write_text('#!/bin/sh\nprintf "%s\\n" "$@"\n')
    command.chmod(0o755)
    return {**os.environ, "PATH": f"{folder}:{os.environ['PATH']}", "RECIPE": str(shared.bare)}


@pytest.fixture(scope="module")
def serial(shared: Shared) -> dict[str, str]:
    return hashes(shared.dataset(shared.bare, scenes=3, formats=("bop",)))


def run(command: list[str], environment: dict[str, str]) -> None:
    """Run what a scheduler starts, and the command line that it comes to in this process, as starting it takes long."""
    words = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
    assert main(words.splitlines()) == 0


def merged(out: Path, environment: dict[str, str]) -> dict[str, str]:
    script = re.search(r"`(warehouse-sim generate --merge \"\$OUT\".*?)`", DOCS.read_text())
    assert script is not None
    run(["bash", "-c", script.group(1)], environment | {"OUT": str(out)})
    return hashes(out / "merged")


def test_a_slurm_array_makes_the_dataset_of_one_run(environment, serial, tmp_path: Path) -> None:
    script = tmp_path / "job.sh"
    script.write_text(block("bash"))
    first, last = re.search(r"--array=(\d+)-(\d+)", script.read_text()).groups()  # type: ignore[union-attr]
    tasks = range(int(first), int(last) + 1)
    # https://slurm.schedmd.com/job_array.html, https://slurm.schedmd.com/sbatch.html
    given = {"OUT": str(tmp_path), "SLURM_ARRAY_TASK_COUNT": str(len(tasks)), "SLURM_CPUS_PER_TASK": "1"}
    for task in tasks:
        run(["bash", str(script)], environment | given | {"SLURM_ARRAY_TASK_ID": str(task)})
    assert merged(tmp_path, environment) == serial


@pytest.mark.slow
def test_an_indexed_kubernetes_job_makes_the_dataset_of_one_run(environment, serial, tmp_path: Path) -> None:
    job = yaml.safe_load(block("yaml"))["spec"]
    (container,) = job["template"]["spec"]["containers"]
    assert job["completionMode"] == "Indexed"
    assert job["completions"] == 2
    values = {item["name"]: item["value"] for item in container["env"]}
    values |= {"RECIPE": environment["RECIPE"], "OUT": str(tmp_path)}
    for index in range(job["completions"]):
        # https://kubernetes.io/docs/tasks/job/indexed-parallel-processing-static/
        values["JOB_COMPLETION_INDEX"] = str(index)
        arguments = [
            re.sub(r"\$\((\w+)\)", lambda match: values[match.group(1)], item)
            for item in container["command"] + container["args"]
        ]
        run(arguments, environment | values)
    assert merged(tmp_path, environment) == serial
