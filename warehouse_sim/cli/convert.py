"""``warehouse-sim convert``: a dataset that is there, ours or third-party, is written in further formats."""

from pathlib import Path

import tyro

from warehouse_sim.cli.console import count_progress, finish
from warehouse_sim.errors import InputError


def convert(
    data: tyro.conf.Positional[Path], to: tuple[str, ...], out: Path, resume: bool = False, overwrite: bool = False
) -> None:
    """Write a dataset in other formats, scene by scene; images are linked where the disk can, not copied.

    Args:
        data: Dataset folder, of this package or a third-party one.
        to: Formats to write, see ``warehouse-sim list``.
        out: Dataset folder to make.
        resume: Go on with a run that was interrupted; finished scenes are kept.
        overwrite: Remove the dataset that stands in the folder first.
    """
    if overwrite and resume:
        raise InputError("--overwrite begins again and --resume goes on; give one of them")
    from warehouse_sim.api.folders import convert as run

    with count_progress("scenes") as progress:
        run(data, out, to, resume, overwrite, progress)
    finish(out, "validate", out)
