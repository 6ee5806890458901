"""``generate --on slurm-array`` submits an array and a merge; run as Slurm runs them, they make the bytes of one run.

``sbatch`` is a stand-in that runs each task at once with the variables that Slurm sets
(https://slurm.schedmd.com/job_array.html, https://slurm.schedmd.com/sbatch.html).
"""

import os
import sys
from pathlib import Path

import pytest

from tests.shared import Shared, hashes
from warehouse_sim.cli.main import main

SBATCH = """\
#!/bin/bash
set -e
for script; do :; done
echo "$@" >>"$SUBMITTED"
number=$(wc -l <"$SUBMITTED")
last=$(sed -n 's/^#SBATCH --array=0-//p' "$script")
export SLURM_CPUS_PER_TASK=$(sed -n 's/^#SBATCH --cpus-per-task=//p' "$script")
if [ -z "$last" ]; then bash "$script" >&2; else
    export SLURM_ARRAY_TASK_COUNT=$((last + 1))
    for task in $(seq 0 "$last"); do SLURM_ARRAY_TASK_ID=$task bash "$script" >&2; done
fi
echo "$number;cluster"
"""


@pytest.fixture
def slurm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the file that lists what was submitted."""
    command, submitted = tmp_path / "bin" / "sbatch", tmp_path / "submitted"
    command.parent.mkdir()
    command.write_text(SBATCH)
    command.chmod(0o755)
    monkeypatch.setenv("PATH", f"{command.parent}:{os.environ['PATH']}")
    monkeypatch.setenv("SUBMITTED", str(submitted))
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, sys.path)))
    return submitted


@pytest.mark.gl
def test_array_and_merge_make_the_dataset_of_one_run(slurm: Path, shared: Shared, tmp_path: Path) -> None:
    out = tmp_path / "made with a space"
    words = ["generate", str(shared.bare), "--scenes", "3", "--formats", "bop", "--out", str(out)]
    assert main([*words, "--on", "slurm-array", "--tasks", "2"]) == 0
    first, second = slurm.read_text().splitlines()
    assert first.startswith("--parsable /")
    assert second.startswith("--parsable --dependency=afterok:1 ")
    assert hashes(out) == hashes(shared.dataset(shared.bare, scenes=3, formats=("bop",)))


def test_no_more_tasks_than_scenes_and_what_a_task_may_use(
    slurm: Path, shared: Shared, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "bin" / "sbatch").write_text("#!/bin/sh\necho no such partition >&2; exit 1\n")
    words = ["generate", str(shared.small), "--scenes", "3", "--out", str(tmp_path / "made"), "--on", "slurm-array"]
    assert main([*words, "--workers", "4"]) != 0
    assert "no such partition" in capsys.readouterr().err
    (script,) = (tmp_path / "made.shards").rglob("shards.sh")
    assert "#SBATCH --array=0-2\n#SBATCH --cpus-per-task=4\n" in script.read_text()


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--on", "slurm-array"], "no sbatch"),
        (["--on", "kubernetes"], "must be ray, ray://HOST"),
        (["--on", "ray", "--resume"], "--resume out"),
        (["--on", "ray", "--tasks", "0"], "--tasks must be at least 1"),
        (["--shards", "shards"], "give --on too"),
    ],
)
def test_what_cannot_be_is_rejected_before_the_work(
    words: list[str], says: str, shared: Shared, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["generate", str(shared.small), "--out", str(tmp_path / "made"), *words]) == 2
    assert says in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "made").exists()


def test_a_folder_that_holds_something_is_rejected_before_the_work(
    slurm: Path, shared: Shared, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["generate", str(shared.small), "--out", str(tmp_path), "--on", "slurm-array"]
    assert main(words) == 2
    assert "is not empty" in capsys.readouterr().err
    assert not slurm.exists()
