"""Images whose files bear the key of their scene and image: in shards, or side by side in a folder (BOP imagewise)."""

from functools import cached_property
from pathlib import Path
from typing import Protocol

from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.dataset.files.plain import shown
from warehouse_sim.dataset.formats.bop.shards.archive import Extent, Members, list_members
from warehouse_sim.dataset.formats.bop.shards.layout import KEY_TO_SHARD, MEMBER, SHARD, image_key
from warehouse_sim.errors import DatasetError

_MOST_BYTES = 2**28


class Keyed(Protocol):
    """The images of one split."""

    def numbers(self) -> list[tuple[int, int]]:
        """Return scene and image of every image, sorted."""

    def find(self, key: tuple[int, int], kind: str) -> Extent | None:
        """Return where a file of an image lies, if there is one, by its kind such as "rgb.png"."""

    def member(self, key: tuple[int, int], kind: str) -> Extent:
        """Return what ``find`` does.

        Raises:
            DatasetError: There is none.
        """

    def files(self) -> list[Path]:
        """Return all files, sorted."""


class _Listed:
    """What is common of both: images are found in one table of members."""

    def __init__(self, root: Path) -> None:
        self.root = root

    @cached_property
    def _members(self) -> Members:
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
            raise DatasetError(f"{self.root}: {image_key(*key)}.{kind} is missing; copy or generate the dataset again")
        return found


class ShardFolder(_Listed):
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
                    raise DatasetError(f"{path}: {image_key(*key)} is in an earlier shard, too; make them again")
                if table is not None and table.get(key) != int(match[1]):
                    raise DatasetError(
                        f"{self.root / KEY_TO_SHARD}: {image_key(*key)} is {shown(table.get(key))}, the image is in "
                        f"{path.name}; make the table again"
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


class ImagewiseFolder(_Listed):
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
