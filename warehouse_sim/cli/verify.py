"""``warehouse-sim verify``: a dataset against its checksums, and against itself made again."""

from pathlib import Path

import tyro

from warehouse_sim.cli.console import count_progress, finish
from warehouse_sim.cli.validate import word
from warehouse_sim.errors import InputError
from warehouse_sim.optional import require_extra


def verify(data: tyro.conf.Positional[Path], samples: int = 3) -> int:
    """Check every file against the checksums, make some observations again and compare; exit code 1 on a difference.

    Where the driver that drew the dataset draws here, bytes are compared; where another one does, geometry and labels
    exactly and pixels within a tolerance. A line says which was done.

    Args:
        data: Dataset folder, made from a recipe.
        samples: Observations to make again, at least, 1-1,000,000; whole scenes are made.
    """
    require_extra("generate", "to make scenes again")
    from warehouse_sim.generation.verify import verify as run

    if not 1 <= samples <= 1_000_000:
        raise InputError(f"--samples must be 1 to 1000000, found {samples}")
    with count_progress("scenes") as progress:
        checks = run(data, samples, progress)
    for check in checks:
        print(f"{word(check)}  {check.name}: {check.detail}")
    if not all(check.ok for check in checks):
        print(f"output: {data} is not the dataset that its recipe and seed make")
        return 1
    finish(data, "validate", data)
    return 0
