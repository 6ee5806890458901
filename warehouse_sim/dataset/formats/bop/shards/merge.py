"""Stream archives of single scenes into shards; what was interrupted is taken up again, what is done is kept."""

import shutil
from collections.abc import Sequence

from warehouse_sim.dataset.files.json_file import parse_json, write_json
from warehouse_sim.dataset.formats.bop.shards.archive import Extent, Members, add_image, list_members, writing_archive
from warehouse_sim.dataset.formats.bop.shards.layout import MOST_IMAGES, ShardsLayout, image_key
from warehouse_sim.dataset.formats.bop.targets import TargetLists
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.errors import DatasetError
from warehouse_sim.output import make_folder, whole_file, writing

_Key = tuple[int, int]


def merge(layout: ShardsLayout, manifest: Manifest, most_images: int = MOST_IMAGES) -> None:
    """Write all shards, one image in memory at a time, and remove the scenes that are in them.

    Args:
        layout: Paths of the format's folder.
        manifest: Of the dataset.
        most_images: Of one shard.

    Raises:
        DatasetError: A scene is neither in its part nor in its shard.
    """
    targets = TargetLists()
    for split in SPLITS:
        keys = [(scene, i) for scene in manifest.splits[split] for i in range(manifest.observations_per_scene)]
        if not keys:
            continue
        make_folder(layout.split(split))
        table: dict[str, int] = {}
        for number, start in enumerate(range(0, len(keys), most_images)):
            chunk = keys[start : start + most_images]
            members = _write_shard(layout, split, number, chunk)
            table |= {image_key(*key): number for key in chunk}
            if split == "test":
                _add_targets(targets, members)
            # A scene goes on in the next shard unless its last image is in this one.
            _remove_parts(layout, chunk, manifest.observations_per_scene - 1)
        write_json(layout.key_to_shard(split), table)
    targets.write(layout.bop.root)
    if layout.parts.is_dir():
        with writing(layout.parts):
            shutil.rmtree(layout.parts)


def _write_shard(layout: ShardsLayout, split: str, number: int, keys: Sequence[_Key]) -> Members:
    """Write a shard of parts, and of the shard itself where it was made before; return its members."""
    path = layout.shard(split, number)
    stored = list_members(path) if path.is_file() else {}
    fresh = {scene for scene, _ in keys if layout.part(scene).is_file()}
    if not fresh and set(stored) == set(keys):
        return stored
    part: Members = {}
    with whole_file(path) as file, writing_archive(file) as archive:
        for key in keys:
            if key[0] in fresh and key not in part:
                part = list_members(layout.part(key[0]))
            found: dict[str, Extent] | None = part.get(key) if key[0] in fresh else stored.get(key)
            if found is None:
                raise DatasetError(
                    f"{path}: image {image_key(*key)} is neither in {layout.part(key[0])} nor in the shard; "
                    "generate the dataset again"
                )
            add_image(archive, image_key(*key), {kind: extent.read() for kind, extent in found.items()})
    return list_members(path)


def _add_targets(targets: TargetLists, members: Members) -> None:
    for (scene, image), kinds in members.items():
        rows = [parse_json(kinds[kind].read(), kinds[kind].where) for kind in ("gt.json", "gt_info.json")]
        targets.add(scene, image, *rows)


def _remove_parts(layout: ShardsLayout, keys: Sequence[_Key], last: int) -> None:
    for scene, image in keys:
        if image == last:
            with writing(layout.part(scene)):
                layout.part(scene).unlink(missing_ok=True)
