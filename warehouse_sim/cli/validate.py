"""``warehouse-sim validate``: one line a check."""

from pathlib import Path

import tyro

from warehouse_sim.cli.console import finish
from warehouse_sim.errors import DatasetError


def validate(data: tyro.conf.Positional[Path]) -> int:
    """Check a dataset folder; exit code 0 only if all checks hold, 1 otherwise.

    Args:
        data: Dataset folder.
    """
    from warehouse_sim.dataset.validate import validate as run

    if not data.is_dir():
        raise DatasetError(f"{data}: is not a folder; make a dataset with warehouse-sim generate")
    checks = run(data)
    for check in checks:
        print(f"{'ok  ' if check.ok else 'FAIL'}  {check.name}: {check.detail}")
    failed = sum(not check.ok for check in checks)
    print(f"{len(checks) - failed} of {len(checks)} checks hold")
    if failed:
        print(f"output: {data} is not usable as it is; generate it again into an empty folder")
        return 1
    finish(data, "train", "densefusion-pointcloud", "--data", data, "--out", f"{data}-run")
    return 0
