"""The shards of a dataset as a job array of Slurm, and a job that merges them when all are done."""

import shlex
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from warehouse_sim.errors import InputError, WorkerError
from warehouse_sim.output import make_folder, write_bytes

_HEAD = """\
#!/bin/bash
#SBATCH --job-name={name}
#SBATCH --output={log}
"""
_OF_SHARDS = """\
#SBATCH --array=0-{last}
#SBATCH --cpus-per-task={workers}
#SBATCH --requeue
exec {command} --out {shards}/shard-"$SLURM_ARRAY_TASK_ID" --shard "$SLURM_ARRAY_TASK_ID/{count}" \\
    --workers "$SLURM_CPUS_PER_TASK" --resume
"""


@dataclass(frozen=True)
class Submitted:
    """Numbers of the jobs."""

    shards: str
    """Of the array."""
    merge: str
    """Of the job that waits for it."""


def submit(arguments: Sequence[str], out: Path, shards: Path, tasks: int, workers: int, overwrite: bool) -> Submitted:
    """Write both job scripts into the folder of the shards, and submit them.

    Args:
        arguments: Of ``warehouse-sim generate``: the recipe and all that decides the bytes.
        out: Dataset folder that the second job makes.
        shards: Folder that all nodes reach; each task makes its shard in it, and goes on where it was stopped.
        tasks: Of the array.
        workers: Processors of each task.
        overwrite: Whether the merge removes the dataset that stands in ``out``.

    Raises:
        InputError: This machine has no sbatch.
        WorkerError: Slurm did not take a job.
    """
    if shutil.which("sbatch") is None:
        raise InputError("--on slurm-array: there is no sbatch here; run it where jobs are submitted to Slurm")
    make_folder(shards)
    program = [sys.executable, "-m", "warehouse_sim", "generate"]
    made = shlex.join([*program, *arguments])
    array = _OF_SHARDS.format(
        last=tasks - 1, workers=workers, command=made, shards=shlex.quote(str(shards)), count=tasks
    )
    merged = shlex.join([*program, "--merge", *(str(shards / f"shard-{task}") for task in range(tasks))])
    more = " --overwrite" if overwrite else ""
    first = _submit(shards / "shards.sh", "warehouse-sim", "task-%a.log", array)
    waits = f"--dependency=afterok:{first}"
    merge = f"exec {merged} --out {shlex.quote(str(out))}{more}\n"
    return Submitted(first, _submit(shards / "merge.sh", "warehouse-sim-merge", "merge.log", merge, waits))


def _submit(script: Path, name: str, log: str, body: str, *options: str) -> str:
    """Write a job script, submit it and return its number."""
    head = _HEAD.format(name=name, log=script.with_name(log))
    write_bytes(script, f"{head}{body}".encode())
    command = ["sbatch", "--parsable", *options, str(script)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise WorkerError(f"{shlex.join(command)}: {done.stderr.strip() or done.stdout.strip()}")
    return done.stdout.strip().partition(";")[0]
