"""Checks of BOP shards: other eyes than the reader's open them, the numbers are held to the records."""

import json
import tarfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool

from warehouse_sim.dataset.checks import poses
from warehouse_sim.dataset.checks.findings import Findings, NamedCheck
from warehouse_sim.dataset.checks.labels import agree_with_record, decode_runs, lie_apart
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.formats.bop.shards.layout import MOST_IMAGES, shards_layout
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.dataset.split import SPLITS, Split
from warehouse_sim.errors import DatasetError

_KINDS = ("rgb.png", "depth.png", "camera.json", "gt.json", "gt_info.json", "mask.json", "mask_visib.json")
_CLEAN = ("rgb_clean.png", "depth_clean.png")


def archives(subject: Subject) -> Findings:
    """Each split's shards are full but the last; members stand image by image, each once, with the kinds of all."""
    findings, kinds = Findings(), sorted((*_KINDS, *(_CLEAN if subject.readable.has_clean else ())))
    for split in SPLITS:
        folder = shards_layout(subject.root).split(split)
        images = len(subject.manifest.splits[split]) * subject.manifest.observations_per_scene
        count = -(-images // MOST_IMAGES)
        expected = {f"shard-{number:06d}.tar" for number in range(count)} | ({"key_to_shard.json"} if images else set())
        found = {path.name for path in folder.iterdir()} if folder.is_dir() else set()
        findings.require(found == expected, f"{folder}: holds {sorted(found ^ expected)[:3]} too many or too few")
        for number in range(count):
            path = shards_layout(subject.root).shard(split, number)
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


def rows(subject: Subject) -> Findings:
    """Cameras and poses are those of the scene records."""
    findings, count = Findings(), 0
    for image in subject.images():
        where = f"{shards_layout(subject.root).split(image.split)}: scene {image.scene_id} image {image.image_id}"
        agree_with_record(findings, subject, image, where)
        count += len(image.targets)
    findings.examined = f"{count} poses, equal to the scene records"
    return findings


def masks(subject: Subject) -> Findings:
    """Run lengths, decoded by pycocotools, lie in each other, do not overlap, and have the stored counts."""
    findings = Findings()
    for split in SPLITS:
        images = {(image.scene_id, image.image_id): image for image in subject.readable.images(split)}
        for number in range(-(-len(images) // MOST_IMAGES)):
            _masks_of_shard(findings, subject, split, number, images)
    findings.examined = f"{findings.count} pairs of masks"
    return findings


def _masks_of_shard(
    findings: Findings, subject: Subject, split: Split, number: int, images: dict[tuple[int, int], ImageRecord]
) -> None:
    path = shards_layout(subject.root).shard(split, number)
    with _opened(path) as archive:
        for name in [name for name in archive.getnames() if name.endswith(".mask.json")]:
            key, where = name.partition(".")[0], f"{path}/{name}"
            scene, _, index = key.partition("_")
            image = images[int(scene), int(index)]
            whole = _decoded(archive, f"{key}.mask.json", image, where)
            seen = _decoded(archive, f"{key}.mask_visib.json", image, where)
            taken = np.zeros((image.camera.height, image.camera.width), dtype=bool)
            for target in image.targets:
                a, b = whole[target.gt_index], seen[target.gt_index]
                here = f"{where}: {target.gt_index}"
                lie_apart(findings, b, a, taken, here)
                counts = (
                    int(np.count_nonzero(b)) == target.pixels_visible and int(np.count_nonzero(a)) <= target.pixels_all
                )
                findings.require(counts, f"{here}: {np.count_nonzero(b)} pixels, gt_info has {target.pixels_visible}")
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


CHECKS = (
    NamedCheck("bop_webdataset shards", archives),
    NamedCheck("bop_webdataset rows", rows),
    NamedCheck("bop_webdataset masks", masks),
    NamedCheck("bop_webdataset poses on images", poses.projection),
)
