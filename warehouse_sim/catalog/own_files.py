"""Objects of a user's own files: one that a .yaml file describes, or a mesh file alone.

``crate.glb`` is such a mesh, ``crate.glb#bottle_crate`` gives it a name. What was read is kept until a file changes:
who edits one in a session gets what it says now.
"""

import os
import re
import zlib
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from warehouse_sim.catalog.custom import load_custom_object, mesh_of, object_of
from warehouse_sim.catalog.custom_config import FIRST_OBJ_ID, CustomObjectConfig
from warehouse_sim.catalog.mesh_files import SUFFIXES
from warehouse_sim.errors import ConfigError, shown
from warehouse_sim.schema import ObjectModel

MATERIAL = "plastic_grey"
"""Surface of a mesh that no YAML file describes."""
_DENSITY = 150.0
"""Mass over the volume of its bounding box (kg/m^3), that of a loaded carton; practical prior."""
_LEAST_MASS = 0.1
_NUMBERS = 999_000
_NAME = re.compile("[a-z][a-z0-9_]*")


def is_mesh_name(name: str) -> bool:
    """Return whether a name of a recipe stands for a mesh file, ``PATH`` or ``PATH#NAME``."""
    return Path(name.partition("#")[0]).suffix.lower() in SUFFIXES


def reject_other_file(name: str) -> None:
    """Reject a name that is that of a file, but of none that holds an object.

    Raises:
        ConfigError: It has a suffix.
    """
    suffix = Path(name.partition("#")[0]).suffix
    if suffix and not suffix[1:].isdigit():
        raise ConfigError(f"{shown(name)}: an object is no {suffix} file; known: .yaml, {', '.join(SUFFIXES)}")


def mesh_name(path: str | Path, name: str | None = None) -> str:
    """Return what a recipe writes for a mesh file that is called ``name`` there.

    Raises:
        ConfigError: The name is not lower case letters, digits and _.
    """
    if name is None:
        return str(path)
    if not _NAME.fullmatch(name):
        raise ConfigError(f"name: {shown(name)} must be lower case letters, digits and _, such as {_named(name)!r}")
    return f"{path}#{name}"


def load_mesh_object(text: str) -> ObjectModel:
    """Read a mesh file as an object whose origin is the centre of its bounding box, z up.

    A YAML file of the same stem beside it says what it is (docs/custom_objects.md). Without one, its name is its class,
    its ``obj_id`` follows from the name, it is grey plastic, has the mass of a loaded carton of its size, and collides
    as its bounding box.

    Args:
        text: ``PATH`` or ``PATH#NAME``; the name is by default that of the file.

    Raises:
        ConfigError: The file cannot be read, or its size is that of no object.
        MissingPackageError: The package that reads this kind of mesh file is not installed.
    """
    file, _, own = text.partition("#")
    path = Path(file)
    beside = path.with_suffix(".yaml")
    if os.path.isfile(beside):
        model = load_custom_object(beside)
        return replace(model, name=own) if own else model
    if not os.path.isfile(path):
        raise ConfigError(f"{path}: there is no such mesh file; check the path")
    name = own or _named(path.stem)
    number = FIRST_OBJ_ID + zlib.crc32(name.encode()) % _NUMBERS
    config = CustomObjectConfig(name, name, number, path.name, material=MATERIAL)
    model = object_of(config, path)
    return replace(model, mass=max(_DENSITY * float(np.prod(model.size)), _LEAST_MASS))


def _named(text: str) -> str:
    """Return a text as the name of an object."""
    plain = re.sub("[^a-z0-9]+", "_", str(text).lower()).strip("_")
    return plain if _NAME.fullmatch(plain) else f"object_{plain}".rstrip("_")


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
