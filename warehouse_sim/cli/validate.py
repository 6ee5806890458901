"""``warehouse-sim validate``: one line a check."""

from pathlib import Path

import tyro

from warehouse_sim.cli.console import count_progress, finish, fraction_progress, say
from warehouse_sim.dataset.checks.findings import Check
from warehouse_sim.errors import InputError
from warehouse_sim.optional import require_extra

_ADVICE = """\
next:   if files were lost or changed since it was generated, generate it again into an empty folder; if not, that gives
        the same bytes: report the lines above together with {manifest}"""


def validate(data: tyro.conf.Positional[Path], regenerate: int | None = None) -> int:
    """Check a dataset folder; exit code 0 only if all checks hold, 1 otherwise.

    With --regenerate its files are compared with their checksums, and some scenes with the same ones generated again.
    Where the driver that rendered the dataset renders here, bytes are compared; where another one does, geometry and
    labels exactly and pixels within a tolerance. A line says which was done.

    Args:
        data: Dataset folder.
        regenerate: Generate at least so many observations again and compare, 1-1,000,000; whole scenes are made.
    """
    if regenerate is not None:
        return _regenerate(data, regenerate)
    from warehouse_sim.api.folders import validate as run
    from warehouse_sim.dataset.manifest import dataset_around

    around = dataset_around(data)
    if around is not None:
        say(f"warning: {data} is a part of a dataset; to check all of it, name {around}")
    with fraction_progress("validate") as progress:
        checks = run(data, progress)
    for check in checks:
        print(f"{word(check)}  {check.name}: {check.detail}")
    requested = [check for check in checks if check.checked]
    failed = sum(not check.ok for check in requested)
    print(f"{len(requested) - failed} of {len(requested)} checks hold")
    if failed:
        print(f"output: {data} is not usable as it is")
        if checks[0].ok and (data / "manifest.json").is_file():
            print(_ADVICE.format(manifest=data / "manifest.json"))
        return 1
    if around is not None:
        finish(data, "validate", around)
        return 0
    finish(data, "train", "densefusion-pointcloud", "--data", data, "--out", f"{data}-run")
    return 0


def word(check: Check) -> str:
    """Return how a line begins."""
    return ("ok  " if check.ok else "FAIL") if check.checked else "--  "


def _regenerate(data: Path, samples: int) -> int:
    """Compare a dataset with its checksums, and some of its scenes with the same ones generated again."""
    require_extra("generate", "to make scenes again")
    from warehouse_sim.generation.verify import verify as run

    if not 1 <= samples <= 1_000_000:
        raise InputError(f"--regenerate must be 1 to 1000000, found {samples}")
    with count_progress("scenes") as progress:
        checks = run(data, samples, progress)
    for check in checks:
        print(f"{word(check)}  {check.name}: {check.detail}")
    if not all(check.ok for check in checks):
        print(f"output: {data} is not the dataset that its recipe and seed make")
        return 1
    finish(data, "validate", data)
    return 0
