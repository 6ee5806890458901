"""Shards become the dataset that one run would have made: their files are put together, and it is finished once."""

import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from warehouse_sim.config import to_mapping
from warehouse_sim.dataset.discard import discard_dataset
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest, load_manifest
from warehouse_sim.dataset.shards.shard import Shard, read_shard
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.errors import DatasetError
from warehouse_sim.one_writer import is_lock, one_writer
from warehouse_sim.output import is_temporary, link_or_copy, make_folder
from warehouse_sim.schema.outputs import in_words

ProgressCallback = Callable[[int, int], None]
"""Called with the number of shards that are in place and of all shards."""
_MOST_NAMED = 12


def merge(
    parts: Sequence[Path],
    out: Path,
    resume: bool = False,
    progress: ProgressCallback = lambda done, total: None,
    skip_failed: bool = False,
    overwrite: bool = False,
) -> Manifest:
    """Make the dataset folder ``out`` of all shards of a dataset; files are linked where the disk can, else copied.

    Args:
        parts: Folders of the shards, in any order; they stay as they are.
        out: Folder to make; it must be empty unless ``resume`` or ``overwrite``.
        resume: Go on with a merge that was interrupted.
        progress: Called after each shard.
        skip_failed: Do without scenes that shards lack; the manifest names them.
        overwrite: Remove the dataset that stands in ``out``, once the shards are checked.

    Raises:
        DatasetError: A folder is no shard or lacks scenes, shards are of different datasets, come twice or are
            missing, or hold different files of one name.
        OutputError: Another process writes the folder, or it cannot be written.
    """
    manifest = _require_whole(parts, skip_failed)
    place, places = Path(os.path.realpath(out)), {part: Path(os.path.realpath(part)) for part in parts}
    for part, other in places.items():
        if place.is_relative_to(other):
            raise DatasetError(f"{out}: lies in the shard {part}; choose a folder beside it")
        if overwrite and other.is_relative_to(place):
            raise DatasetError(f"{out}: holds the shard {part}, which would be overwritten; choose a folder beside it")
    store = DatasetStore(out, manifest)
    with one_writer(out):
        if overwrite:
            discard_dataset(out)
        store.claim(resume)
        for done, part in enumerate(parts):
            progress(done, len(parts))
            _take_files(part, out)
        progress(len(parts), len(parts))
        return store.finish(store.pending() if skip_failed else ())


def _require_whole(parts: Sequence[Path], skip_failed: bool) -> Manifest:
    """Return the manifest of the dataset that the shards make together.

    Raises:
        DatasetError: They make none.
    """
    if not parts:
        raise DatasetError("name the folders of all shards")
    found: dict[int, Path] = {}
    first = manifest = None
    for part in parts:
        shard, theirs = _read(part, skip_failed)
        first, manifest = first or shard, manifest or theirs
        _require_same(manifest, theirs, parts[0], part)
        if shard.count != first.count:
            raise DatasetError(f"{part}: is shard {shard}, {parts[0]} is shard {first}; merge shards of one number")
        if shard.index in found:
            raise DatasetError(f"{part}: is shard {shard}, and so is {found[shard.index]}; name each shard once")
        found[shard.index] = part
    assert first is not None
    assert manifest is not None
    missing = [str(Shard(index, first.count)) for index in range(first.count) if index not in found]
    if missing:
        raise DatasetError(f"shards {_listed(missing)} are missing; make each with warehouse-sim generate --shard I/N")
    return manifest


def _read(part: Path, skip_failed: bool) -> tuple[Shard, Manifest]:
    """Return which shard a folder is, and the manifest of the dataset, when it has the scenes that it must.

    Raises:
        DatasetError: It is no shard, or lacks scenes.
    """
    layout, shard = DatasetLayout(part), read_shard(part)
    if shard is None:
        raise DatasetError(
            f"{part}: is no shard, it has no {layout.shard.name}; make one with warehouse-sim generate --shard I/N"
        )
    manifest = load_manifest(layout.unfinished)
    lacking = [str(index) for index in shard.scenes(manifest.scenes) if not layout.scene_record(index).is_file()]
    if lacking and not skip_failed:
        raise DatasetError(
            f"{part}: shard {shard} lacks the scenes {_listed(lacking)}; "
            f"go on with warehouse-sim generate --shard {shard} --resume, or do without them by --skip-failed"
        )
    return shard, manifest


def _require_same(one: Manifest, other: Manifest, where_one: Path, where: Path) -> None:
    if (wanted := in_words(one.contents.outputs)) != (found := in_words(other.contents.outputs)):
        raise DatasetError(
            f"{where}: holds other outputs: {found} where {where_one} holds {wanted}; "
            "make it again with the same --outputs"
        )
    before, now = to_mapping(one), to_mapping(other)
    different = [key for key in now if before[key] != now[key]]
    if different:
        raise DatasetError(
            f"{where}: was made with a different value of {different[0]} than {where_one}; "
            "merge shards of one recipe, seed, number of scenes, formats and versions"
        )


def _take_files(part: Path, out: Path) -> None:
    """Put the files of a shard in place.

    Raises:
        DatasetError: Another shard has another file of that name, or it is a link.
    """
    for name in _files(part):
        source, path = part / name, out / name
        if source.is_symlink():
            raise DatasetError(f"{source}: is a link; a shard holds files only")
        if not path.exists():
            make_folder(path.parent)
            link_or_copy(source, path)
        elif not path.samefile(source) and path.read_bytes() != source.read_bytes():
            raise DatasetError(f"{source}: is not the file that another shard has of that name; make the shards again")


def _files(part: Path) -> Iterator[Path]:
    own = DatasetLayout(part)
    for path in sorted(part.rglob("*")):
        of_run = path in (own.unfinished, own.shard) or is_lock(path) or is_temporary(path)
        if (path.is_symlink() or not path.is_dir()) and not of_run:
            yield path.relative_to(part)


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
    return ", ".join(names[:_MOST_NAMED]) + more
