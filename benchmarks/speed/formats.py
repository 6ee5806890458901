"""What eight formats at once cost against KITTI and BOP: whole runs of generate, scene, sensors and files included."""

import os
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from benchmarks.speed.subject import Settings

TWO = ("kitti", "bop")
EIGHT = (*TWO, "bop_webdataset", "coco", "yolo", "linemod", "mcap", "ply")
_ROUNDS, _QUICK_ROUNDS = 3, 1


def formats(settings: Settings) -> dict[str, Any]:
    """Return the row; runs of two and of eight formats take turns."""
    spent: dict[tuple[str, ...], list[float]] = {TWO: [], EIGHT: []}
    size: dict[tuple[str, ...], float] = {}
    observations = 0
    with tempfile.TemporaryDirectory() as folder:
        for number in range(_QUICK_ROUNDS if settings.quick else _ROUNDS):
            for names, seconds in spent.items():
                out = Path(folder) / f"{number}_{len(names)}"
                seconds.append(_generate(settings, names, out))
                size[names] = _disk_use(out)
                observations = len(list((out / "bop").rglob("rgb/*.png")))
    ours, peer = statistics.median(spent[EIGHT]), statistics.median(spent[TWO])
    return {
        "what": f"generate one scene of {settings.recipe}, {observations} observations, in eight formats at once",
        "ours_cpu_s": ours,
        "peer_cpu_s": peer,
        "target": "<= 1.6x",
        "peer": "the same in KITTI and BOP",
        "gb_for_1000": {f"{len(names)} formats": size[names] / observations / 1e6 for names in size},
        "how": f"CPU-seconds of the command and its workers, with its start; {', '.join(EIGHT)}; medians",
    }


def _generate(settings: Settings, names: tuple[str, ...], out: Path) -> float:
    """Return the CPU-seconds of a run."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "warehouse_sim", "generate", settings.recipe, "--seed", str(settings.seed)]
    command += ["--scenes", "1", "--workers", "1", "--out", str(out), "--formats", *names]
    subprocess.run(command, check=True, capture_output=True, env={**os.environ, "OMP_NUM_THREADS": "1"})
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def _disk_use(folder: Path) -> float:
    """Return the bytes of a folder's files, each inode once."""
    found = {path.stat().st_ino: path.stat().st_size for path in folder.rglob("*") if path.is_file()}
    return float(sum(found.values()))
