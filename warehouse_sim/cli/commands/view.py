"""``warehouse-sim view`` and ``validate``: a dataset in a viewer, as a page, as a summary, and by its checks."""

import os
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from warehouse_sim.cli.console import count_progress, finish, fraction_progress, require_ending, say
from warehouse_sim.dataset.checks.findings import Check
from warehouse_sim.dataset.files.extent import ADVICE
from warehouse_sim.errors import DatasetError, InputError
from warehouse_sim.optional import require_extra
from warehouse_sim.output import make_folder, write_bytes

if TYPE_CHECKING:
    from warehouse_sim.dataset.reader import DatasetReader
    from warehouse_sim.dataset.records import ImageRecord

_PICTURES = 6
"""Images on the contact sheet by default."""
_PORT = 8088


def view(
    data: tyro.conf.Positional[Path],
    split: str | None = None,
    limit: int | None = None,
    save: Path | None = None,
    html: Path | None = None,
    web: bool = False,
    port: int = _PORT,
    open3d: bool = False,
    summary: bool = False,
    out: Path | None = None,
) -> None:
    """Look at a dataset: images, depth, clouds, boxes and tracks, in the Rerun viewer, a browser or Open3D.

    Without an option it opens the Rerun viewer. --html and --web need no display here. With --summary it opens no
    viewer: it prints counts, histograms and oddities, and writes a contact sheet of images with their labels. Any
    folder in a format that this package reads can be viewed.

    Args:
        data: Dataset folder.
        split: Images of this split; of all by default.
        limit: At most so many images, >= 1: all by default, 300 chosen ones on a page, 6 on the contact sheet of
            --summary (at most 100), the first with --open3d.
        save: File to write (.rrd) in place of opening a viewer, for a machine without a display.
        html: Page to write (.html) that a browser opens without a network.
        web: Serve that page on the loopback address, until Ctrl-C.
        port: Port of --web, 0-65535; 0 for any that is free.
        open3d: Open one window of Open3D after the other with cloud and boxes.
        summary: Print what the dataset holds, and write contact_sheet.png and survey.txt.
        out: With --summary, folder for both files; DATA-summary by default.
    """
    if limit is not None and limit < 1:
        raise InputError(f"--limit must be at least 1, found {limit}")
    if not data.is_dir():
        raise DatasetError(f"{data}: is not a folder; make a dataset with warehouse-sim generate")
    ways = {"--save": save is not None, "--html": html is not None, "--web": web, "--open3d": open3d}
    chosen = [*(name for name, given in ways.items() if given), *(["--summary"] if summary else [])]
    if len(chosen) > 1:
        raise InputError(f"{' and '.join(chosen)} are different ways to look at a dataset; leave one of them out")
    if summary:
        _summarise(data, out, _PICTURES if limit is None else limit, split)
        return
    if out is not None:
        raise InputError("--out belongs to --summary; add --summary, or give --save FILE.rrd or --html FILE.html")
    if html is not None or web:
        _page(data, split, limit, html, port)
    elif open3d:
        _windows(data, split, 1 if limit is None else limit)
    else:
        _stream(data, split, limit, save)


def _stream(data: Path, split: str | None, limit: int | None, save: Path | None) -> None:
    if save is not None:
        require_ending("--save", save, ".rrd")
    require_extra("view", "to view a dataset")
    from warehouse_sim.dataset.viewing.stream import open_recording, stream_images

    reader, images = _opened(data, split)
    images = images[:limit]
    with open_recording(f"{reader.name}-{reader.digest[:12]}", save) as recording, count_progress("images") as progress:
        stream_images(reader, images, recording, progress)
    finish(data if save is None else save)


def _opened(data: Path, split: str | None) -> tuple["DatasetReader", list["ImageRecord"]]:
    """Return a dataset with the images of a split, or of all."""
    from warehouse_sim.dataset.reader import DatasetReader

    reader = DatasetReader(data)
    splits = [name for name in reader.parts if reader.splits[name]] if split in (None, "all") else [str(split)]
    return reader, [image for name in splits for image in reader.images(name)]


def _page(data: Path, split: str | None, limit: int | None, html: Path | None, port: int) -> None:
    """Write a page, or serve it until the user stops it."""
    if html is not None:
        require_ending("--html", html, ".html", ".htm")
    if not 0 <= port < 65536:
        raise InputError(f"--port must be 0 to 65535, found {port}")
    require_extra("report", "to write a page")
    from warehouse_sim.dataset.viewing.page.dataset import dataset_page, served
    from warehouse_sim.dataset.viewing.page.gallery import FRAMES

    reader, images = _opened(data, split)
    page = dataset_page(reader, images, limit or FRAMES)
    if html is not None:
        make_folder(html.parent)
        write_bytes(html, page)
        finish(html)
        return
    with served(page, port) as server:
        print(f"serving: http://127.0.0.1:{server.server_address[1]}/ (Ctrl-C stops)", flush=True)
        with suppress(KeyboardInterrupt):
            server.serve_forever()


def _windows(data: Path, split: str | None, limit: int) -> None:
    """Open a window of Open3D for each image, after it its successor."""
    require_extra("open3d", "to view a dataset with --open3d")
    from warehouse_sim.api.observation import Observation
    from warehouse_sim.api.observation.open3d_view import show

    reader, images = _opened(data, split)
    for image in images[:limit]:
        show(Observation(reader, image))
    finish(data)


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
        print(_line(check))
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
    finish(data, *_after_validate(data))
    return 0


def _after_validate(data: Path) -> tuple[str | Path, ...]:
    """Return the command that comes next: train where that works, else view; none where nothing reads it."""
    from warehouse_sim.dataset.reader import DatasetReader
    from warehouse_sim.estimators.api import LeastVisible

    try:
        reader = DatasetReader(data)
    except DatasetError:  # clouds, streams and label files alone
        return ()
    takes = LeastVisible().takes
    seen = [
        {item.obj_id for image in reader.images(split) for item in image.targets if item.has_pose and takes(item)}
        for split in ("train", "val")
        if split in reader.splits
    ]
    shows = len(seen) == 2 and bool(seen[1]) and seen[1] <= seen[0]  # all objects of val occur in train
    if shows and reader.has_depth and not reader.leaves_out("masks"):
        return "train", "densefusion-pointcloud", "--data", data, "--out", f"{data}-run"
    return "view", data, "--summary"


def _line(check: Check) -> str:
    """Return what is said of a check, without the advice to do what was just done."""
    word = ("ok  " if check.ok else "FAIL") if check.checked else "--  "
    return f"{word}  {check.name}: {check.detail.replace(f'; {ADVICE}', '')}"


def _regenerate(data: Path, samples: int) -> int:
    """Compare a dataset with its checksums, and some of its scenes with the same ones generated again."""
    require_extra("generate", "to make scenes again")
    from warehouse_sim.generation.verify import verify as run

    if not 1 <= samples <= 1_000_000:
        raise InputError(f"--regenerate must be 1 to 1000000, found {samples}")
    with count_progress("scenes") as progress:
        checks = run(data, samples, progress)
    for check in checks:
        print(_line(check))
    if not all(check.ok for check in checks):
        print(f"output: {data} is not the dataset that its recipe and seed make")
        return 1
    finish(data, "validate", data)
    return 0
