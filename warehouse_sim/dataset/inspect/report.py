"""Inspect a dataset: a text that counts and a sheet that shows."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from warehouse_sim.dataset.files.image_io import encode_rgb
from warehouse_sim.dataset.inspect.oddities import Oddities
from warehouse_sim.dataset.inspect.sheet import dataset_sheet
from warehouse_sim.dataset.inspect.survey import spread, survey
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.output import make_folder, write_bytes

SHEET, TEXT = "contact_sheet.png", "survey.txt"


@dataclass(frozen=True)
class Inspection:
    """What was found."""

    lines: list[str]
    """Counts, histograms and oddities."""
    sheet: Path
    """PNG of some images with their labels."""


def inspect(data: Path, out: Path, count: int = 6, split: str | None = None) -> Inspection:
    """Count what a dataset holds and draw some of its images with their labels.

    Args:
        data: Folder of a dataset in any format that can be read, of this package or of others.
        out: Folder for the sheet and the text.
        count: Images on the sheet, >= 1.
        split: Of which split; all by default.

    Raises:
        DatasetError: The folder cannot be read, or has no such split or no image in it.
    """
    reader, oddities = DatasetReader(data), Oddities()
    found = survey(reader, oddities)
    shown = reader.images(split) if split else list(_all_images(reader))
    if not shown:
        raise DatasetError(f"{data}: has no images" + (f" in the split {split}" if split else ""))
    sheet = dataset_sheet(reader, spread(shown, count), oddities)
    odd = oddities.lines()
    lines = [reader.name, *found.lines(), "", *(["odd:", *(f"  {line}" for line in odd)] if odd else ["nothing odd"])]
    make_folder(out)
    write_bytes(out / SHEET, encode_rgb(sheet))
    write_bytes(out / TEXT, ("\n".join(lines) + "\n").encode("utf-8"))
    return Inspection(lines, out / SHEET)


def _all_images(reader: DatasetReader) -> Iterator[ImageRecord]:
    for split in reader.splits:
        yield from reader.images(split)
