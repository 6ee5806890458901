"""Make a fresh frozen set from a suite: seeds of the system's randomness, a public folder, a sealed file beside it.

The public folder says of itself what it is: a datasheet, and Croissant metadata.
"""

import json
import secrets
import shutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from warehouse_sim.benchmark.groups import ground_truths
from warehouse_sim.benchmark.kept import file_digest
from warehouse_sim.benchmark.sealed.public import SPLIT, write_public
from warehouse_sim.benchmark.sealed.seal import ENDING, SUMS, SetFacts, write_sealed
from warehouse_sim.benchmark.sets import made
from warehouse_sim.benchmark.suite import LeastConfig, Suite
from warehouse_sim.dataset.card.croissant import FILE, About, described, write_metadata
from warehouse_sim.dataset.formats.bop import BopLayout
from warehouse_sim.dataset.manifest import read_manifest
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import InputError, OutputError
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.version import __version__

README = "README.md"
_README = """# {name}

Test images of the suite `{suite}`: a BOP folder for each of {count} layouts, with images, calibration (of the world
only tilt and height), CAD models and lists of targets. The ground truth is in `{sealed}`, SHA-256 `{digest}`.

    warehouse-sim predict ESTIMATOR --data {name}/LAYOUT --out mine/LAYOUT.csv --detections DETECTOR+SEGMENTER
    warehouse-sim evaluate mine --sealed {sealed} --out scores

| layout | scenes | images | targets |
|---|---|---|---|
{rows}

## Datasheet

- **Why**: to compare methods that locate pallets in 6D, on halls that nobody trained or tuned on.
- **What**: synthetic colour and depth images. No person, place or brand is real. Targets are pallets of which at
  least a tenth shows.
- **How**: recipes of the same names of warehouse_sim {version}, each with the cameras and noise that it states. What
  is sampled comes from the system's randomness, and nobody chose among sets.
- **What is left out**: the ground truth.
- **Use**: test alone. Train and tune on data of your own making: `warehouse-sim generate LAYOUT`. Scores say nothing
  of a real site.
- **Upkeep**: it never changes. A mistake leads to a set of the next number, on which all are evaluated again; the
  holder of `{sealed}` keeps a log of all evaluations beside it.
- **Licence**: {licence}
"""


def write_about(folder: Path, suite: str, sealed: str, digest: str, licence: str) -> None:
    """Write the datasheet and ``croissant.json``.

    Args:
        folder: The public folder; its name is the set's unless ``sealed`` says another.
        suite: Name of the suite.
        sealed: Name of the sealed file.
        digest: Its SHA-256.
        licence: Of the data.
    """
    name, layouts = Path(sealed).stem, sorted(path for path in folder.iterdir() if path.is_dir())
    rows = "\n".join(_rows(layouts))
    text = _README.format(
        name=name,
        suite=suite,
        count=len(layouts),
        sealed=sealed,
        digest=digest,
        rows=rows,
        version=__version__,
        licence=licence,
    )
    write_bytes(folder / README, text.encode("utf-8"))
    sealed_half = f"the ground truth is sealed, SHA-256 {digest}"
    about = About(
        name=name,
        description=f"Test images of {len(layouts)} synthetic warehouses; {sealed_half}.",
        cite=f"warehouse_sim {__version__}: {name}",
        keywords=("pallet", "6D", "BOP", "RGB-D"),
        licence=licence,
    )
    write_metadata(described(folder, ".", about), folder / FILE)


def _rows(layouts: list[Path]) -> Iterator[str]:
    for root in layouts:
        layout = BopLayout(root)
        targets = json.loads(layout.targets(2019).read_text(encoding="utf-8"))
        scenes = sorted((layout.root / SPLIT).iterdir())
        images = sum(len(list((scene / "depth").iterdir())) for scene in scenes)
        count = sum(target["inst_count"] for target in targets)
        yield f"| `{root.name}` | {len(scenes)} | {images} | {count} |"


_WORK = ".unsealed"
"""Ending of the folder in which a set is made; it has everything, and is gone when the set is sealed."""
Progress = Callable[[str, int, int], None]


def make_set(
    suite: Suite, folder: Path, workers: int, progress: Progress = lambda name, done, total: None
) -> tuple[Path, str]:
    """Make both halves of a set, and return the sealed file and its SHA-256.

    A run that was stopped goes on with the same seeds, which lie in ``folder.unsealed`` until the set is sealed, and
    with all scenes that are whole. So does one whose datasets had too few pallets, once the suite names more scenes.

    Args:
        suite: Whose data are made; their seeds count for nothing.
        folder: Public folder; its name is the set's.
        workers: Processes that generate.
        progress: Called with the dataset, the scenes that are done and how many there are.

    Raises:
        OutputError: The folder or the sealed file is there.
        InputError: The suite has no data that are scored, or a dataset lacks what the suite requires of each.
        RecipeError: A recipe does not take the suite's settings.
    """
    path, work = folder.with_name(folder.name + ENDING), folder.with_name(folder.name + _WORK)
    # A run that was stopped may have sealed already; its public half is not out, so it is made and sealed again.
    for there in (folder, *(() if work.exists() else (path,))):
        if there.exists():
            raise OutputError(f"{there}: is there already; a fresh set has a new name")
    scored = {name: data for name, data in suite.data.items() if not data.trained_on}
    if not scored:
        raise InputError(f"{suite.name}: has no data of its own that could be sealed")
    seeds = seeds_of(work, list(scored))
    roots = {}
    for name, data in scored.items():

        def report(done: int, total: int, name: str = name) -> None:
            progress(name, done, total)

        roots[name] = made(name, replace(data, seed=seeds[name]), work, workers, report).root
    _require_enough(suite.least, roots)
    public = work / "public"
    shutil.rmtree(public, ignore_errors=True)
    for name, root in roots.items():
        write_public(root, public / name)
    facts = SetFacts(folder.name, suite.name, {name: file_digest(public / name) for name in roots}, seeds)
    digest = write_sealed(path, facts, roots)
    licences = {read_manifest(root).licences["data"] for root in roots.values()}
    write_about(public, suite.name, path.name, digest, ", ".join(sorted(licences)))
    write_bytes(public / SUMS, f"{digest}  {path.name}\n".encode())
    public.rename(folder)
    shutil.rmtree(work)
    return path, digest


def _require_enough(least: LeastConfig, roots: Mapping[str, Path]) -> None:
    short = []
    for name, root in roots.items():
        table = ground_truths(DatasetReader(root), SPLIT)
        found = LeastConfig(int(table.evaluated().sum()), len(table))
        if found.dockable < least.dockable or found.ground_truths < least.ground_truths:
            short.append(f"{name} has {found.dockable} of {found.ground_truths}")
    if short:
        raise InputError(
            f"each dataset must have {least.ground_truths} pallets, and {least.dockable} that a truck can take: "
            f"{'; '.join(short)}; raise its scenes in the suite and repeat the command: all other data are kept"
        )


def seeds_of(work: Path, names: list[str]) -> dict[str, int]:
    """Return a seed for each dataset: those of a run that was stopped, and new ones of the system's randomness."""
    path = work / "seeds.json"
    known: dict[str, int] = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    seeds = {name: known.get(name, secrets.randbits(62)) for name in names}
    make_folder(work)
    write_bytes(path, json.dumps(seeds).encode("utf-8"), durable=True)
    return seeds
