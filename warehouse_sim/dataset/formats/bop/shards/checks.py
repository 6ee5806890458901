"""Checks of BOP shards: other eyes than the reader's open them, the numbers are held to the records."""

import json
import tarfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool

from warehouse_sim.dataset.checks import poses
from warehouse_sim.dataset.checks.findings import Findings, NamedCheck
from warehouse_sim.dataset.checks.labels import agree_with_record, decode_runs, lie_apart
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.formats.bop import mask_kinds
from warehouse_sim.dataset.formats.bop.shards import MOST_IMAGES, shards_layout
from warehouse_sim.dataset.formats.bop.shards.coding import LOSSLESS, SMALL, Coding
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.errors import DatasetError


def archives(coding: Coding, subject: Subject) -> Findings:
    """Each split's shards are full but the last; members stand image by image, each once, with the kinds of all."""
    findings, kinds = Findings(), coding.kinds(subject.manifest.contents)
    layout = shards_layout(subject.root, coding.name)
    for split in SPLITS:
        folder = layout.split(split)
        images = len(subject.manifest.splits[split]) * subject.manifest.observations_per_scene
        count = -(-images // MOST_IMAGES)
        expected = {f"shard-{number:06d}.tar" for number in range(count)} | ({"key_to_shard.json"} if images else set())
        found = {path.name for path in folder.iterdir()} if folder.is_dir() else set()
        findings.require(found == expected, f"{folder}: holds {sorted(found ^ expected)[:3]} too many or too few")
        for number in range(count):
            path = layout.shard(split, number)
            with _opened(path) as archive:
                names = archive.getnames()
            keys = list(dict.fromkeys(name.partition(".")[0] for name in names))
            full = min(MOST_IMAGES, images - number * MOST_IMAGES)
            findings.require(len(keys) == full, f"{path}: holds {len(keys)} images, not {full}")
            together = [f"{key}.{kind}" for key in keys for kind in kinds]
            findings.require(names == together, f"{path}: members do not stand image by image with the same kinds")
            findings.count += len(names)
    findings.examined = f"{findings.count} members of shards"
    return findings


def rows(coding: Coding, subject: Subject) -> Findings:
    """Cameras and poses are those of the scene records."""
    findings, count = Findings(), 0
    for image in subject.images():
        folder = shards_layout(subject.root, coding.name).split(image.split)
        where = f"{folder}: scene {image.scene_id} image {image.image_id}"
        agree_with_record(findings, subject, image, where)
        count += len(image.targets)
    findings.examined = f"{count} poses, equal to the scene records"
    return findings


def masks(coding: Coding, subject: Subject) -> Findings:
    """Run lengths, decoded by pycocotools, lie in each other, do not overlap, and have the stored counts."""
    findings, kinds = Findings(), mask_kinds(subject.manifest.contents)
    for split in SPLITS:
        images = {(image.scene_id, image.image_id): image for image in subject.readable.images(split)}
        for number in range(-(-len(images) // MOST_IMAGES)):
            path = shards_layout(subject.root, coding.name).shard(split, number)
            _masks_of_shard(findings, path, images, kinds)
    findings.examined = f"{findings.count} {'pairs of masks' if len(kinds) > 1 else 'masks'}"
    return findings


def _masks_of_shard(
    findings: Findings, path: Path, images: dict[tuple[int, int], ImageRecord], kinds: list[str]
) -> None:
    with _opened(path) as archive:
        for name in [name for name in archive.getnames() if name.endswith(f".{kinds[0]}.json")]:
            key, where = name.partition(".")[0], f"{path}/{name}"
            scene, _, index = key.partition("_")
            image = images[int(scene), int(index)]
            found = {kind: _decoded(archive, f"{key}.{kind}.json", image, where) for kind in kinds}
            taken = np.zeros((image.camera.height, image.camera.width), dtype=bool)
            for target in image.targets:
                at = target.gt_index
                whole, seen = (found[kind][at] if kind in found else None for kind in ("mask", "mask_visib"))
                here = f"{where}: {at}"
                if seen is not None:
                    lie_apart(findings, seen, whole, taken, here)
                    count = int(np.count_nonzero(seen))
                    same = count == target.pixels_visible
                    findings.require(same, f"{here}: {count} pixels, gt_info has {target.pixels_visible}")
                if whole is not None:
                    fits = int(np.count_nonzero(whole)) <= target.pixels_all
                    findings.require(fits, f"{here}: the amodal mask has more pixels than gt_info")
                findings.count += 1


def _decoded(archive: tarfile.TarFile, name: str, image: ImageRecord, where: str) -> list[Bool[np.ndarray, "h w"]]:
    file = archive.extractfile(name)
    data: Any = json.loads(file.read()) if file is not None else None
    if not isinstance(data, dict) or sorted(data) != sorted(str(i) for i in range(len(image.targets))):
        raise DatasetError(f"{where}: must hold run lengths of targets 0 to {len(image.targets) - 1}")
    return [decode_runs(data[str(index)], image, f"{where}: {index}") for index in range(len(data))]


@contextmanager
def _opened(path: Path) -> Iterator[tarfile.TarFile]:
    """Open a shard; what keeps it from being read is the check's failure.

    Raises:
        DatasetError: It is missing or damaged.
    """
    try:
        with tarfile.open(path, "r:") as archive:
            yield archive
    except (OSError, tarfile.TarError, ValueError, KeyError) as problem:
        raise DatasetError(f"{path}: cannot be read ({problem}); generate the dataset again") from problem


def _checks(coding: Coding) -> tuple[NamedCheck, ...]:
    return (
        NamedCheck(f"{coding.name} shards", partial(archives, coding)),
        NamedCheck(f"{coding.name} rows", partial(rows, coding)),
        NamedCheck(f"{coding.name} masks", partial(masks, coding), needs=(("masks",), ("amodal_masks",))),
        NamedCheck(f"{coding.name} poses on images", poses.projection, needs=poses.PROJECTION_NEEDS),
    )


CHECKS, COMPACT_CHECKS = _checks(LOSSLESS), _checks(SMALL)
