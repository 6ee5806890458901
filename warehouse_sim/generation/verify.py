"""Make some scenes of a dataset again, and say whether it holds what they hold, or nearly."""

import re
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
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
from warehouse_sim.generation.plan import GenerateConfig, target_models
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.processes import keep_freed_memory
from warehouse_sim.render import open_renderer

PIXEL_FRACTION = 0.02
"""Images are near where at most that fraction of their pixels is off."""
COLOR_CODES = 8
"""Pixels of colours and masks are off by more codes of 256."""
DEPTH_M, DEPTH_RATIO = 0.005, 0.005
"""Pixels of depth are off by more than so many metres and that ratio."""
DEPTH_STEP = 0.0015
"""Readings of cameras with errors of their own are off by more than so many metres times the square of the distance in
metres, too: two steps of disparity (1/32 px each) of a stereo camera of 447 px and 95 mm, which round another way where
colours differ by a code."""
COUNT, COUNT_RATIO = 3.0, 0.02
"""Numbers of pixels and corners of boxes are near where they differ by at most the larger of both."""
_KITTI_EXACT = (0, 3, *range(8, 15))
"""Fields of a KITTI label that follow from poses: class, angles, size, place."""
_NUMBER = re.compile(r"-?[0-9]+(?:\.[0-9]+)?(?:[eE][-+]?[0-9]+)?")
_MILLIMETRES = 1000.0
_CODES_PER_M = {"depth_2": 256.0, "depth_clean_2": 256.0}
"""KITTI's unit of depth; all others store millimetres."""
_CODES_OFF = {"normals": 1000.0, "object_coordinates": 650.0, "class_mask": 0.0}
"""Images of exact data -> how far codes of 16 bits may differ: 1.7 deg, 1 % of a box, not at all."""
_READINGS = ("depth", "depth_2")
"""Folders of what a depth camera has read; ground truth and disparities take no step."""
_SAMPLED_TEXT = ("scene_gt_info.json", "label_2/", "label_2_ids/")
_EXACT_SUFFIXES = (".json", ".txt", ".bin", ".npz", ".md", ".yaml")
_EXACT_FOLDERS = ("models/", "models_eval/", "damaged/")
_RUNS = "scene_gt_coco.json"


def comparison(name: str) -> Callable[[Path, Path], bool] | None:
    """Return how a file that is no image is compared with the one that another driver made; None = it cannot be.

    Args:
        name: Its name within the dataset.
    """
    if name.endswith(_RUNS):
        return None
    if "label_2/" in name:
        return near_labels
    if any(part in name for part in _SAMPLED_TEXT) or name.startswith("yolo/"):
        return near_numbers
    if name.endswith(_EXACT_SUFFIXES) or any(part in name for part in _EXACT_FOLDERS):
        return equal_bytes
    return None


def equal_bytes(path: Path, other: Path) -> bool:
    """Return whether both files are there and the same."""
    return path.is_file() and path.read_bytes() == other.read_bytes()


def is_image(name: str) -> bool:
    """Return whether a file of a dataset is an image, of colours, depth, disparity or a mask."""
    return name.endswith((".png", ".jpg"))


def fraction_off(path: Path, other: Path, step: float = 0.0) -> float:
    """Return which fraction of the pixels of two images is off, 0-1; 1 where they cannot be compared.

    Args:
        path: One image.
        other: The other one.
        step: Of readings of depth, see ``DEPTH_STEP``; ground truth and disparities take none.
    """
    one, two = (cv2.imread(str(item), cv2.IMREAD_UNCHANGED) for item in (path, other))
    if one is None or two is None or one.shape != two.shape or one.dtype != two.dtype:
        return 1.0
    difference = np.abs(one.astype(np.float64) - two.astype(np.float64))
    worst = difference.max(axis=2) if difference.ndim == 3 else difference
    if (most := _CODES_OFF.get(path.parent.name)) is not None:
        return float(np.mean(worst > most))
    if one.dtype == np.uint16:
        codes = _CODES_PER_M.get(path.parent.name, _MILLIMETRES)
        metres = one / codes
        limit = np.maximum(DEPTH_M, DEPTH_RATIO * metres)
        if path.parent.name in _READINGS:
            limit = np.maximum(limit, step * metres**2)
        return float(np.mean(difference > limit * codes))
    return float(np.mean(worst > COLOR_CODES))


def near_labels(path: Path, other: Path) -> bool:
    """Return whether two KITTI label files say the same of space, and nearly the same of the image."""
    rows, theirs = ([line.split() for line in _text(item).splitlines()] for item in (path, other))
    exact = [[[row[i] for i in _KITTI_EXACT if i < len(row)] for row in found] for found in (rows, theirs)]
    return exact[0] == exact[1] and near_numbers(path, other)


def near_numbers(path: Path, other: Path) -> bool:
    """Return whether two texts differ by no more than a few pixels in each number."""
    one, two = _text(path), _text(other)
    if _NUMBER.sub("0", one) != _NUMBER.sub("0", two):
        return False
    values, theirs = (np.array([float(item) for item in _NUMBER.findall(text)]) for text in (one, two))
    return bool(np.all(np.abs(values - theirs) <= np.maximum(COUNT, COUNT_RATIO * np.abs(values))))


def lasting(record: Any) -> Any:
    """Return a scene record without what is counted in pixels, and the name of the driver."""
    if not isinstance(record, dict):
        return record
    kept = {key: value for key, value in record.items() if key not in ("renderer", "tally", "observations")}
    rows = record.get("observations")
    kept["observations"] = [
        {key: value for key, value in row.items() if key != "targets"} if isinstance(row, dict) else row
        for row in (rows if isinstance(rows, list) else [])
    ]
    return kept


def _text(path: Path) -> str:
    return path.read_bytes().decode("utf-8", "replace") if path.is_file() else "(missing)"


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
