"""``warehouse-sim view`` and ``validate``: a dataset in the Rerun viewer, as a summary, and by its checks."""

import os
from pathlib import Path

import tyro

from warehouse_sim.cli.console import count_progress, finish, fraction_progress, require_ending, say
from warehouse_sim.dataset.checks.findings import Check
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
    from warehouse_sim.dataset.viewing.stream import open_recording, stream_images

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
