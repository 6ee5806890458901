"""Read a YAML file that may come from anyone: plain data only, of bounded size, every key given once."""

import os
from pathlib import Path
from typing import Any

import yaml

from warehouse_sim.errors import ConfigError, shown

_MOST_BYTES = 1_000_000
_MOST_DEPTH = 32
"""Mappings and lists within each other."""
_MOST_VALUES = 100_000
"""Keys and values, those behind an alias counted each time that it stands for them."""
_MOST_DIGITS = 30


def read_yaml(path: Path, error: type[ConfigError] = ConfigError) -> Any:
    """Return the plain data of the YAML file at ``path``.

    Raises:
        error: The file is missing, is not YAML, gives a key twice, or is larger or deeper than settings are.
    """
    try:
        if not os.path.isfile(path):
            raise error(f"{path}: cannot be read (there is no such file); check the path")
        if path.stat().st_size > _MOST_BYTES:
            raise error(f"{path}: is larger than {_MOST_BYTES // 1000} kB; that is no file of settings")
        text = path.read_text(encoding="utf-8")
    except OSError as problem:
        raise error(f"{path}: cannot be read ({problem.strerror}); check the path") from problem
    except ValueError as problem:  # no UTF-8
        raise error(f"{path}: is not valid YAML ({' '.join(str(problem).split())})") from problem
    return parse_yaml(text, str(path), error)


def parse_yaml(text: str, where: str, error: type[ConfigError] = ConfigError) -> Any:
    """Return the plain data of a YAML text.

    Raises:
        error: It is not YAML, gives a key twice, or is deeper than settings are; the message begins with ``where``.
    """
    try:
        return yaml.load(text, _BoundedLoader)
    except _NotTakenError as problem:
        raise error(f"{where}: line {problem.line}: {problem}") from problem
    except (yaml.YAMLError, ValueError) as problem:  # a date like 2026-99-99 is a ValueError
        raise error(f"{where}: is not valid YAML ({' '.join(str(problem).split())})") from problem


class _NotTakenError(Exception):
    """What YAML allows and settings do not."""

    def __init__(self, message: str, mark: yaml.Mark) -> None:
        super().__init__(message)
        self.line = mark.line + 1


class _BoundedLoader(yaml.SafeLoader):
    """PyYAML's safe loader, which counts what it composes."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self._depth = self._count = 0
        self._values_in: dict[yaml.Node | None, int] = {}

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """Return the next node; an alias counts as all that it stands for."""
        mark, is_alias = self.peek_event().start_mark, self.check_event(yaml.AliasEvent)
        self._depth, before = self._depth + 1, self._count
        if self._depth > _MOST_DEPTH:
            raise _NotTakenError(f"nested more than {_MOST_DEPTH} deep; settings are flatter", mark)
        node = super().compose_node(parent, index)
        if is_alias and node not in self._values_in:
            raise _NotTakenError("an alias within what it stands for has no end", mark)
        self._count += self._values_in[node] if is_alias else 1
        if self._count > _MOST_VALUES:
            raise _NotTakenError(f"more than {_MOST_VALUES} values; that is no file of settings", mark)
        self._values_in[node] = self._count - before
        self._depth -= 1
        return node

    def compose_mapping_node(self, anchor: Any) -> yaml.MappingNode:
        """Return the next mapping, whose keys must differ."""
        node = super().compose_mapping_node(anchor)
        seen: dict[tuple[str, str], yaml.ScalarNode] = {}
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode):
                first = seen.setdefault((key.tag, key.value), key)
                if first is not key:
                    line = first.start_mark.line + 1
                    raise _NotTakenError(f"{shown(key.value)} was given in line {line}; keep one", key.start_mark)
        return node

    def construct_yaml_int(self, node: yaml.ScalarNode) -> int:
        """Return a whole number that has no more digits than any setting."""
        if len(node.value) > _MOST_DIGITS:
            raise _NotTakenError(f"an integer of {len(node.value)} digits is no setting", node.start_mark)
        return super().construct_yaml_int(node)


_BoundedLoader.add_constructor("tag:yaml.org,2002:int", _BoundedLoader.construct_yaml_int)
