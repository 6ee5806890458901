"""Objects of a user's own files, kept until a file changes: who edits one in a session gets what it says now."""

import os
from contextlib import suppress
from pathlib import Path

from warehouse_sim.catalog.custom import load_custom_object, mesh_of
from warehouse_sim.catalog.mesh_object import is_mesh_name, load_mesh_object
from warehouse_sim.errors import ConfigError
from warehouse_sim.schema import ObjectModel

_State = tuple[int, int, int] | None
"""Inode, time of the last change (ns) and size; None where there is no such file."""
_KEPT: dict[str, tuple[dict[str, _State], ObjectModel]] = {}
"""By absolute path: the states of all files that an object was read from, and the object."""


def is_file_name(name: str) -> bool:
    """Return whether a name of a recipe stands for a file, .yaml or mesh, and not for an object of the catalog."""
    return name.endswith(".yaml") or is_mesh_name(name)


def object_of_files(name: str) -> ObjectModel:
    """Return the object of a .yaml or mesh file; the same object as long as no file of it changes.

    Args:
        name: ``PATH`` or, for a mesh, ``PATH#NAME``.

    Raises:
        ConfigError: A file cannot be read, or describes no object.
        MissingPackageError: The package that reads this kind of mesh file is not installed.
    """
    key = os.path.abspath(name)
    kept = _KEPT.get(key)
    if kept is None or any(_state(path) != state for path, state in kept[0].items()):
        states = {path: _state(path) for path in _files(name)}
        model = load_custom_object(Path(name)) if name.endswith(".yaml") else load_mesh_object(name)
        kept = _KEPT[key] = states, model
    return kept[1]


def _files(name: str) -> list[str]:
    """Return the files that an object is read from, with the .yaml file that may come to stand beside a mesh."""
    path = Path(name.partition("#")[0])
    described = path.with_suffix(".yaml")
    found = [path, described]
    if os.path.isfile(described):
        with suppress(ConfigError):  # which who reads it says better
            found.append(mesh_of(described))
    return [os.path.abspath(item) for item in found]


def _state(path: str) -> _State:
    try:
        found = os.stat(path)
    except (OSError, ValueError):
        return None
    return found.st_ino, found.st_mtime_ns, found.st_size
