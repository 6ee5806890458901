"""One of several runs that make a dataset together, each in a folder of its own: every n-th scene is its."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.dataset.files.json_file import read_json, write_json
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.errors import ConfigError, DatasetError, InputError, shown
from warehouse_sim.ranges import Range, ranged


@dataclass(frozen=True)
@ranged
class Shard:
    """The scenes whose index leaves ``index`` when divided by ``count``: near ones, which are alike, are spread."""

    index: Annotated[int, Range(0, 999_999)]
    """Which of them, 0-999,999 and below ``count``, as job arrays number their tasks."""
    count: Annotated[int, Range(1, 1_000_000)]
    """How many there are, 1-1,000,000."""

    def __post_init__(self) -> None:
        if not 0 <= self.index < self.count:
            raise ValueError(f"of {self.count} shards there is no {self.index}; they are 0 to {self.count - 1}")

    def __str__(self) -> str:
        return f"{self.index}/{self.count}"

    def scenes(self, total: int) -> range:
        """Return its scenes in a dataset of ``total``."""
        return range(self.index, total, self.count)


def parse_shard(text: str) -> Shard:
    """Return the shard that ``text`` names, such as 0/4.

    Raises:
        InputError: It names none.
    """
    if not re.fullmatch(r"[0-9]{1,7}/[0-9]{1,7}", text):
        raise InputError(f"--shard {shown(text)}: must be i/n, such as 0/4 for the first of four")
    index, count = map(int, text.split("/"))
    try:
        return Shard(index, count)
    except (ValueError, ConfigError) as problem:
        raise InputError(f"--shard {text}: {problem}") from problem


def write_shard(root: Path, shard: Shard) -> None:
    """Say of a folder that it is a shard."""
    write_json(DatasetLayout(root).shard, to_mapping(shard))


def read_shard(root: Path) -> Shard | None:
    """Return which shard a folder is; None where it is none.

    Raises:
        DatasetError: The file that says so is malformed.
    """
    path = DatasetLayout(root).shard
    if not path.is_file():
        return None
    try:
        return from_mapping(Shard, read_json(path), str(path))
    except ConfigError as problem:
        raise DatasetError(str(problem)) from problem
