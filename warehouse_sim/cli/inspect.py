"""``warehouse-sim inspect``: what a dataset holds, in numbers and in pictures."""

import os
from pathlib import Path

import tyro

from warehouse_sim.cli.console import finish
from warehouse_sim.errors import InputError


def inspect(
    data: tyro.conf.Positional[Path],
    out: Path | None = None,
    count: int = 6,
    split: str | None = None,
) -> None:
    """Show a dataset that anyone made: counts, histograms, oddities, and a contact sheet with its labels.

    Args:
        data: Dataset folder, of this package or of others.
        out: Folder for contact_sheet.png and survey.txt; DATA-inspect by default.
        count: Images on the contact sheet, 1-100.
        split: Show images of this split; of all by default.
    """
    from warehouse_sim.dataset.inspect import inspect as run

    if not 1 <= count <= 100:
        raise InputError(f"--count must be 1 to 100, found {count}")
    folder = out or Path(os.path.realpath(data)).with_name(f"{Path(os.path.realpath(data)).name}-inspect")
    found = run(data, folder, count, split)
    print("\n".join(found.lines))
    finish(found.sheet)
