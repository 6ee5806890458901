"""Make some scenes of a dataset again, and say whether it holds what they hold."""

import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from warehouse_sim.config import from_mapping
from warehouse_sim.dataset.checks.findings import Check, Findings
from warehouse_sim.dataset.files.checksums import broken_seals
from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest, package_versions, read_manifest
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.dataset.stored.scene_record import read_scene_record
from warehouse_sim.errors import ConfigError, DatasetError
from warehouse_sim.generation.generate import Job, make_scene
from warehouse_sim.generation.near_files import (
    DEPTH_STEP,
    PIXEL_FRACTION,
    comparison,
    equal_bytes,
    fraction_off,
    is_image,
    lasting,
)
from warehouse_sim.generation.plan import GenerateConfig, target_models
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.generation.workers import keep_freed_memory
from warehouse_sim.render import open_renderer

ProgressCallback = Callable[[int, int], None]
"""Called with the number of scenes that are regenerated and of all that will be."""
_PIECES = "parts"
"""Folders of formats in which scenes wait to be put together; they are gone from a complete dataset."""


def verify(root: Path, samples: int, progress: ProgressCallback = lambda done, total: None) -> list[Check]:
    """Compare a dataset with its checksums, and some of its scenes with the same ones regenerated.

    Where the same renderer draws here, every byte must be the same. Where another driver does, geometry and labels
    are compared exactly and pixels within a tolerance, see ``near_files``.

    Args:
        root: Folder of the dataset.
        samples: Observations to make again, at least; whole scenes are made.
        progress: Called after each scene.

    Raises:
        DatasetError: The folder is no complete dataset, or one made by third parties.
        RenderError: No renderer can be opened.
    """
    manifest = read_manifest(root)
    recipe = _recipe(root, manifest)
    checks = [_checksums(root, manifest)]
    indices = chosen_scenes(manifest, samples)
    keep_freed_memory()
    with (
        tempfile.TemporaryDirectory(prefix="warehouse-sim-verify-") as folder,
        open_renderer(manifest.backend or "raster", **manifest.backend_options) as renderer,
    ):
        again = Path(folder)
        job = Job(recipe, replace(manifest, checksums=""), again, GenerateConfig(seed=manifest.seed))
        DatasetStore(again, job.manifest).begin(target_models(recipe), recipe.sensors.make_camera())
        others: list[int] = []
        for done, index in enumerate(indices):
            progress(done, len(indices))
            if read_scene_record(root, index, objects=False).renderer != renderer.description:
                others.append(index)
            make_scene(job, index, renderer)
        progress(len(indices), len(indices))
        checks.append(_driver(manifest, renderer.description, others))
        made = f"{len(indices) * manifest.observations_per_scene} observations of {len(indices)} scenes regenerated"
        step = DEPTH_STEP if manifest.contents.depth_bias else 0.0
        checks += _near(root, again, made, step) if others else [_same(root, again, made)]
    return checks


def chosen_scenes(manifest: Manifest, samples: int) -> list[int]:
    """Return the scenes that hold ``samples`` observations, drawn by the dataset's own seed."""
    there = manifest.scene_indices
    count = min(-(-samples // manifest.observations_per_scene), len(there))
    rng = np.random.default_rng([manifest.seed, manifest.scenes, samples])
    return sorted(int(index) for index in rng.choice(there, count, replace=False))


def _recipe(root: Path, manifest: Manifest) -> Recipe:
    """Return the recipe that the dataset was made from.

    Raises:
        DatasetError: It was made from none, or its recipe is not one of this version.
    """
    where = f"{DatasetLayout(root).manifest}: recipe"
    if manifest.by_hand:
        raise DatasetError(f"{root}: its scenes were put together in Python; run that script again, or see validate")
    if manifest.converted_from or not manifest.recipe:
        raise DatasetError(f"{root}: was converted from other data, nothing can be regenerated; see validate")
    try:
        return from_mapping(Recipe, manifest.recipe, where)
    except ConfigError as problem:
        raise DatasetError(f"{problem}; verify it with the version that made it, {_made_by(manifest)}") from problem


def _checksums(root: Path, manifest: Manifest) -> Check:
    findings = Findings("every file is the one that SHA256SUMS lists, and that list the one that manifest.json names")
    try:
        for line in broken_seals(root, manifest.checksums):
            findings.require(False, line)
    except DatasetError as problem:
        findings.require(False, str(problem))
    return findings.outcome("checksums")


def _driver(manifest: Manifest, here: str, others: list[int]) -> Check:
    versions = package_versions()
    changed = {name: old for name, old in manifest.packages.items() if versions.get(name) != old}
    text = f"{here}, which drew it; bytes are compared"
    if others:
        text = f"{here}, drawn by {' and '.join(manifest.renderers)}; geometry and labels exact, images near"
    return Check(
        "driver",
        True,
        "; ".join(
            [text, *(f"made with {name} {old}, here {versions.get(name, 'none')}" for name, old in changed.items())]
        ),
    )


def _made_by(manifest: Manifest) -> str:
    return f"warehouse-sim {manifest.packages.get('warehouse-sim', 'unknown')}"


def _same(root: Path, again: Path, made: str) -> Check:
    """Compare bytes."""
    findings = Findings()
    for name in _names(again):
        findings.count += 1
        findings.require(equal_bytes(root / name, again / name), f"{root / name}: is not what is made now")
    findings.examined = f"{made}, the same bytes in {findings.count} files"
    return findings.outcome("regenerated")


def _near(root: Path, again: Path, made: str, step: float) -> list[Check]:
    """Compare what another driver may not change, and what it draws within a tolerance; ``step``: see fraction_off."""
    exact, near, left, worst = Findings(), Findings(), 0, (0.0, "all")
    for name in _names(again):
        compare = comparison(name)
        if is_image(name):
            off = fraction_off(root / name, again / name, step)
            same, worst = off <= PIXEL_FRACTION, max(worst, (off, name))
        elif name.startswith("scenes/"):
            same = lasting(read_json(root / name)) == lasting(read_json(again / name))
        elif compare is not None:
            same = compare(root / name, again / name)
        else:
            left += 1
            continue
        findings = exact if compare is equal_bytes else near
        findings.count += 1
        findings.require(same, f"{root / name}: is not what is made now")
    exact.examined = f"{made}, the same in {exact.count} files"
    near.examined = (
        f"{near.count} files within the tolerance of docs/trust.md, pixels off: at most {worst[0]:.3%}, in {worst[1]}; "
        f"{left} of other kinds not compared"
    )
    return [exact.outcome("geometry and labels"), near.outcome("pixels")]


def _names(folder: Path) -> Iterator[str]:
    unfinished = DatasetLayout(folder).unfinished
    for path in sorted(item for item in folder.rglob("*") if item.is_file()):
        name = path.relative_to(folder)
        if path != unfinished and _PIECES not in name.parts:
            yield name.as_posix()
