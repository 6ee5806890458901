"""Make a fresh frozen set from a suite: seeds of the system's randomness, a public folder, a sealed file beside it."""

import json
import secrets
import shutil
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from warehouse_sim.benchmark.groups import ground_truths
from warehouse_sim.benchmark.kept import file_digest
from warehouse_sim.benchmark.sealed.about import write_about
from warehouse_sim.benchmark.sealed.public import SPLIT, write_public
from warehouse_sim.benchmark.sealed.seal import ENDING, SUMS, SetFacts, write_sealed
from warehouse_sim.benchmark.sets import made
from warehouse_sim.benchmark.suite import LeastConfig, Suite
from warehouse_sim.dataset.manifest import read_manifest
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import InputError, OutputError
from warehouse_sim.output import make_folder, write_bytes

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
