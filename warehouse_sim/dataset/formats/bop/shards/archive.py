"""Where images and their rows lie in folders of shards and of images: members of plain tar archives, or files.

Archives are written so that equal members give equal bytes, read by name and never unpacked.
"""

import io
import tarfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import BinaryIO

from warehouse_sim.dataset.files.extent import Extent
from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.dataset.formats.bop.shards import KEY_TO_SHARD, MEMBER, SHARD
from warehouse_sim.dataset.layout import observation_name
from warehouse_sim.errors import DatasetError, shown

_MOST_MEMBERS = 1_000_000
_MOST_BYTES = 2**28
"""Of one member: an image of the largest size that is decoded, uncompressed."""

Members = dict[tuple[int, int], dict[str, Extent]]
"""By scene and image: kind ("rgb.png") -> where its bytes lie."""


@contextmanager
def writing_archive(file: BinaryIO) -> Iterator[tarfile.TarFile]:
    """Open a tar archive to write into; headers have no time, owner or place."""
    with tarfile.open(fileobj=file, mode="w", format=tarfile.USTAR_FORMAT) as archive:
        yield archive


def add_image(archive: tarfile.TarFile, key: str, members: Mapping[str, bytes]) -> None:
    """Append the members of an image, sorted by kind, so that readers of streams find them together."""
    for kind in sorted(members):
        header = tarfile.TarInfo(f"{key}.{kind}")
        header.size, header.mtime, header.mode = len(members[kind]), 0, 0o644
        archive.addfile(header, io.BytesIO(members[kind]))


def list_members(path: Path) -> Members:
    """Return the members of a shard by scene, image and kind, without reading them.

    Raises:
        DatasetError: It is no plain tar archive, is cut off, or holds anything but files named like images of BOP.
    """
    members: Members = {}
    try:
        total = path.stat().st_size
        # "r:" takes no compression: what is read is never longer than the file.
        with tarfile.open(path, "r:") as archive:
            number = 0
            while (item := archive.next()) is not None:
                number += 1
                if number > _MOST_MEMBERS:
                    raise DatasetError(f"{path}: holds more than {_MOST_MEMBERS} members; split it")
                _add(members, path, item, total)
    except OSError as problem:
        raise DatasetError(f"{path}: cannot be read ({problem.strerror}); the dataset is incomplete") from problem
    except tarfile.TarError as problem:
        raise DatasetError(f"{path}: is no plain tar archive, or is damaged ({problem}); copy it again") from problem
    return members


def _add(members: Members, path: Path, item: tarfile.TarInfo, total: int) -> None:
    name = item.name.removeprefix("./")
    if item.isdir() and name in (".", ""):
        return
    found = MEMBER.fullmatch(name)
    if found is None or item.type not in (tarfile.REGTYPE, tarfile.AREGTYPE) or item.sparse is not None:
        raise DatasetError(f"{path}: holds {item.name[:80]!r}; a shard holds files such as 000003_000017.rgb.png only")
    if item.size > _MOST_BYTES or item.offset_data + item.size > total:
        raise DatasetError(
            f"{path}/{name}: has {item.size} bytes, of which {total - item.offset_data} are there and {_MOST_BYTES} "
            "are read at most; copy the archive again"
        )
    kinds = members.setdefault((int(found[1]), int(found[2])), {})
    if found[3] in kinds:
        raise DatasetError(f"{path}/{name}: comes twice; make the archive again")
    kinds[found[3]] = Extent(path, name, item.offset_data, item.size)


class Keyed:
    """The images of one split, which are found in one table of members.

    Args:
        root: Their folder.
    """

    def __init__(self, root: Path) -> None:
        self.root = root

    @cached_property
    def _members(self) -> Members:
        raise NotImplementedError

    def files(self) -> list[Path]:
        """Return all files, sorted."""
        raise NotImplementedError

    def numbers(self) -> list[tuple[int, int]]:
        """Return scene and image of every image, sorted."""
        return sorted(self._members)

    def find(self, key: tuple[int, int], kind: str) -> Extent | None:
        """Return where a file of an image lies, if there is one, by its kind such as "rgb.png"."""
        return self._members.get(key, {}).get(kind)

    def member(self, key: tuple[int, int], kind: str) -> Extent:
        """Return what ``find`` does.

        Raises:
            DatasetError: There is none.
        """
        found = self.find(key, kind)
        if found is None:
            raise DatasetError(
                f"{self.root}: {observation_name(*key)}.{kind} is missing; copy or generate the dataset again"
            )
        return found


class ShardFolder(Keyed):
    """Shards: tar archives with a table that says which image is in which."""

    def files(self) -> list[Path]:
        """Return the shards and their table, sorted."""
        found = sorted(self.root.iterdir()) if self.root.is_dir() else []
        return [path for path in found if SHARD.fullmatch(path.name) or path.name == KEY_TO_SHARD]

    @cached_property
    def _members(self) -> Members:
        """All members of all shards.

        Raises:
            DatasetError: An image is in two shards, or in another one than the table says.
        """
        members: Members = {}
        table = self._table()
        for path in self.files():
            match = SHARD.fullmatch(path.name)
            if match is None:
                continue
            for key, kinds in list_members(path).items():
                if key in members:
                    raise DatasetError(f"{path}: {observation_name(*key)} is in an earlier shard, too; make them again")
                if table is not None and table.get(key) != int(match[1]):
                    raise DatasetError(
                        f"{self.root / KEY_TO_SHARD}: {observation_name(*key)} is {shown(table.get(key))}, the image "
                        f"is in {path.name}; make the table again"
                    )
                members[key] = kinds
        return members

    def _table(self) -> dict[tuple[int, int], int] | None:
        path = self.root / KEY_TO_SHARD
        if not path.is_file():
            return None
        data = read_json(path)
        table = {}
        for name, number in data.items() if isinstance(data, dict) else ():
            match = MEMBER.fullmatch(f"{name}.rgb.png")
            if match is None or type(number) is not int:
                raise DatasetError(f"{path}: {shown(name)}: {shown(number)} is no image and shard")
            table[int(match[1]), int(match[2])] = number
        return table


class ImagewiseFolder(Keyed):
    """Files of all images side by side, as bop_toolkit makes them on the way to shards."""

    def files(self) -> list[Path]:
        """Return all files that are named like those of an image, sorted."""
        return [path for path in sorted(self.root.iterdir()) if MEMBER.fullmatch(path.name) and path.is_file()]

    @cached_property
    def _members(self) -> Members:
        """All files by image and kind.

        Raises:
            DatasetError: One is larger than any image.
        """
        members: Members = {}
        for path in self.files():
            match, size = MEMBER.fullmatch(path.name), path.stat().st_size
            assert match is not None
            if size > _MOST_BYTES:
                raise DatasetError(f"{path}: has {size} bytes; {_MOST_BYTES} are read at most")
            members.setdefault((int(match[1]), int(match[2])), {})[match[3]] = Extent(path, "", 0, size)
        return members
