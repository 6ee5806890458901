"""``warehouse-sim view``: a dataset in the Rerun viewer, as a recording for it, or as a summary."""

import os
from pathlib import Path

import tyro

from warehouse_sim.cli.console import count_progress, finish, require_ending
from warehouse_sim.errors import DatasetError, InputError
from warehouse_sim.optional import require_extra

_PICTURES = 6
"""Images on the contact sheet by default."""


def view(
    data: tyro.conf.Positional[Path],
    split: str | None = None,
    limit: int | None = None,
    save: Path | None = None,
    summary: bool = False,
    out: Path | None = None,
) -> None:
    """Stream observations to the Rerun viewer: images, depth, boxes, masks, clouds, rig and its way.

    With --summary it opens no viewer: it prints counts, histograms and oddities, and writes a contact sheet of images
    with their labels. Any folder in a format that this package reads can be viewed.

    Args:
        data: Dataset folder.
        split: Images of this split; of all by default.
        limit: At most so many images, >= 1: all by default, 6 on the contact sheet of --summary (at most 100).
        save: File to write (.rrd) in place of opening a viewer, for a machine without a display.
        summary: Print what the dataset holds, and write contact_sheet.png and survey.txt.
        out: With --summary, folder for both files; DATA-summary by default.
    """
    if limit is not None and limit < 1:
        raise InputError(f"--limit must be at least 1, found {limit}")
    if not data.is_dir():
        raise DatasetError(f"{data}: is not a folder; make a dataset with warehouse-sim generate")
    if summary and save is not None:
        raise InputError("--save is a recording for the viewer, which --summary does not open; leave one of them out")
    if summary:
        _summarise(data, out, _PICTURES if limit is None else limit, split)
        return
    if out is not None:
        raise InputError("--out belongs to --summary; add --summary, or give --save FILE.rrd")
    if save is not None:
        require_ending("--save", save, ".rrd")
    require_extra("view", "to view a dataset")
    from warehouse_sim.dataset.reader import DatasetReader
    from warehouse_sim.dataset.viewing.sink import open_recording
    from warehouse_sim.dataset.viewing.stream import stream_images

    reader = DatasetReader(data)
    splits = [name for name in reader.splits if reader.splits[name]] if split in (None, "all") else [split]
    images = [image for name in splits for image in reader.images(name)][:limit]
    with open_recording(f"{reader.name}-{reader.digest[:12]}", save) as recording, count_progress("images") as progress:
        stream_images(reader, images, recording, progress)
    finish(data if save is None else save)


def _summarise(data: Path, out: Path | None, count: int, split: str | None) -> None:
    from warehouse_sim.dataset.manifest import dataset_around
    from warehouse_sim.dataset.viewing.report import inspect

    if count > 100:
        raise InputError(f"--limit must be 1 to 100 with --summary, found {count}")
    place = Path(os.path.realpath(data))
    whole = dataset_around(place) or place  # beside it, as what lies in it is checked by validate
    name = f"{whole.name}-{place.name}-summary" if whole != place else f"{place.name}-summary"
    found = inspect(data, out or whole.with_name(name), count, None if split == "all" else split)
    print("\n".join(found.lines))
    finish(found.sheet)
