"""``warehouse-sim validate``: one line a check."""

from pathlib import Path

import tyro

from warehouse_sim.cli.console import finish, fraction_progress
from warehouse_sim.dataset.checks.findings import Check
from warehouse_sim.errors import DatasetError

_ADVICE = """\
next:   if files were lost or changed since it was generated, generate it again into an empty folder; if not, that gives
        the same bytes: report the lines above together with {manifest}"""


def validate(data: tyro.conf.Positional[Path]) -> int:
    """Check a dataset folder; exit code 0 only if all checks hold, 1 otherwise.

    Args:
        data: Dataset folder.
    """
    from warehouse_sim.dataset.validate import validate as run

    if not data.is_dir():
        raise DatasetError(f"{data}: is not a folder; make a dataset with warehouse-sim generate")
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
    finish(data, "train", "densefusion-pointcloud", "--data", data, "--out", f"{data}-run")
    return 0


def word(check: Check) -> str:
    """Return how a line begins."""
    return ("ok  " if check.ok else "FAIL") if check.checked else "--  "
