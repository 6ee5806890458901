"""Objects of a user's own files: a YAML file beside a mesh file, or a mesh file alone, becomes a model.

``crate.glb`` is such a mesh, ``crate.glb#bottle_crate`` gives it a name. What was read is kept until a file changes:
who edits one in a session gets what it says now.
"""

import os
import re
import zlib
from collections.abc import Collection, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from warehouse_sim.catalog.custom_config import FIRST_OBJ_ID, CustomObjectConfig
from warehouse_sim.catalog.materials import materials
from warehouse_sim.catalog.mesh_files import SUFFIXES, read_parts
from warehouse_sim.catalog.parts import mesh_part, solid_box
from warehouse_sim.catalog.shipped import SHIPPED
from warehouse_sim.config import load_yaml
from warehouse_sim.errors import ConfigError, shown
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.mesh import TriangleMesh, merge
from warehouse_sim.geometry.symmetry import SymmetryGroup, surface_kept
from warehouse_sim.schema import Material, ObjectModel

_SMALLEST, _LARGEST = 0.005, 60.0
"""Limits of the longest edge (m), beyond which the unit is probably wrong."""
_THINNEST = 0.001
"""Least edge (m); physics has no bodies without a volume."""
_MOST_SLENDER = 10_000.0
"""Longest edges of all triangles over the root of their area; 5 for a box, 500 for 100,000 even triangles."""
_OUTSIDE = 0.001
"""How far (m) a collision box may leave the object."""


def load_custom_object(path: Path, brought: Sequence[Material] = ()) -> ObjectModel:
    """Read the object that the YAML file at ``path`` describes; its origin is the centre of its bounding box, z up.

    Args:
        path: The file.
        brought: Materials that the file may name beside those of the catalog.

    Raises:
        ConfigError: The file, a key of it or the mesh file cannot be used; the message names file and key.
        MissingPackageError: The package that reads this kind of mesh file is not installed.
    """
    return object_of(load_yaml(CustomObjectConfig, path), path, brought)


def object_of(config: CustomObjectConfig, path: Path, brought: Sequence[Material] = ()) -> ObjectModel:
    """Return the object that settings describe.

    Args:
        config: What the mesh file does not say.
        path: The file that says it, beside which the mesh file lies.
        brought: As in ``load_custom_object``.

    Raises:
        ConfigError: A setting or the mesh file cannot be used; the message names file and key.
        MissingPackageError: The package that reads this kind of mesh file is not installed.
    """
    if config.name in SHIPPED:
        raise ConfigError(f"{path}: name: {config.name!r} is an object of the catalog; choose another")
    try:
        meshes = read_parts(_inside(path, config.file), config.up, config.scale)
    except ConfigError as problem:
        raise ConfigError(f"{path}: file: {problem}") from problem
    vertices = np.concatenate([mesh.vertices[np.unique(mesh.faces)] for mesh in meshes.values()])
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    size = high - low
    if not _SMALLEST <= size.max() <= _LARGEST:
        raise ConfigError(f"{path}: scale: the object is {_edges(size)} m; 0.001 is for millimetres, 0.01 for cm")
    if size.min() < _THINNEST:
        raise ConfigError(f"{path}: file: the object is {_edges(size)} m; each edge must be at least {_THINNEST} m")
    _reject_slivers(meshes.values(), f"{path}: file: {config.file}")
    centred = {name: _solid(mesh, (low + high) / 2) for name, mesh in meshes.items()}
    known = materials() | {material.name: material for material in brought}
    chosen = _materials(config, list(meshes), known, path)
    return ObjectModel(
        name=config.name,
        class_name=config.class_name,
        obj_id=config.obj_id,
        size=size,
        parts=tuple(mesh_part(mesh, material) for mesh, material in zip(centred.values(), chosen, strict=True)),
        collision=_collision(config, centred, size, path),
        mass=config.mass,
        bears=config.bears,
        symmetry=_symmetry(config, merge(list(centred.values())), path),
        materials=tuple(material for material in brought if material.name in chosen),
    )


def mesh_of(path: Path) -> Path:
    """Return the mesh file that the YAML file at ``path`` names.

    Raises:
        ConfigError: The YAML file cannot be used, or there is no such mesh file beside it.
    """
    return _inside(path, load_yaml(CustomObjectConfig, path).file)


def _inside(path: Path, file: str) -> Path:
    """Return the mesh file, which must lie in the folder of the YAML file or below."""
    folder = Path(os.path.realpath(path)).parent
    if "\0" in file or not (found := Path(os.path.realpath(folder / file))).is_relative_to(folder):
        raise ConfigError(f"{shown(file)} leaves the folder of the YAML file; copy it there")
    if not os.path.isfile(found):
        raise ConfigError(f"{shown(file)} does not exist in {folder}")
    return found


def _reject_slivers(meshes: Collection[TriangleMesh], where: str) -> None:
    """Reject a surface that is made of lines: it has nothing to draw, and no even mesh of it has an end.

    Raises:
        ConfigError: It has next to no area for the length of its triangles.
    """
    triangles = np.concatenate([mesh.vertices[mesh.faces] for mesh in meshes])
    edges = np.linalg.norm(np.roll(triangles, -1, axis=1) - triangles, axis=2).max(axis=1)
    area = sum(mesh.face_areas().sum() for mesh in meshes)
    if edges.sum() > _MOST_SLENDER * np.sqrt(area):
        raise ConfigError(
            f"{where} has next to no area: {area:.3g} m^2 in {len(edges)} triangles of up to {edges.max():.3g} m; "
            "repair and export it again"
        )


def _solid(mesh: TriangleMesh, centre: np.ndarray) -> TriangleMesh:
    """Return the mesh about ``centre``; one that is inside out as a whole is turned."""
    moved = mesh.vertices - centre
    a, b, c = np.moveaxis(moved[mesh.faces] - moved.mean(axis=0), 1, 0)
    inside_out = np.einsum("ij,ij->", a, np.cross(b, c)) < 0.0
    return TriangleMesh(moved, np.ascontiguousarray(mesh.faces[:, ::-1]) if inside_out else mesh.faces)


def _materials(config: CustomObjectConfig, parts: list[str], known: Collection[str], path: Path) -> list[str]:
    """Return the name of each part's material, one of ``known``."""
    named = {f"materials.{part}": name for part, name in config.materials.items()}
    for key, name in {"material": config.material, **named}.items():
        if name is not None and name not in known:
            raise ConfigError(f"{path}: {key}: unknown material {name!r}; known: {', '.join(sorted(known))}")
    for part in config.materials:
        if part not in parts:
            raise ConfigError(f"{path}: materials: the file has no part {part!r}; it has {', '.join(parts)}")
    chosen = [config.materials.get(part, config.material) for part in parts]
    if None in chosen:
        part = parts[chosen.index(None)]
        raise ConfigError(f"{path}: material: part {part!r} has none; name it in 'materials' or set 'material'")
    return [name for name in chosen if name is not None]


def _symmetry(config: CustomObjectConfig, surface: TriangleMesh, path: Path) -> SymmetryGroup:
    """Return the declared group, unless one of its turns moves the surface elsewhere."""
    chosen = config.symmetry
    if chosen.kind == "none":
        return SymmetryGroup.trivial()
    group = SymmetryGroup.cuboid() if chosen.kind == "cuboid" else SymmetryGroup.turns(chosen.axis, chosen.count)
    if moved := np.flatnonzero(~surface_kept(surface, group.transforms)).tolist():
        raise ConfigError(
            f"{path}: symmetry: turn {moved[0]} of {len(group) - 1} moves the surface elsewhere; "
            "declare fewer turns or another axis"
        )
    return group


def _collision(
    config: CustomObjectConfig, meshes: dict[str, TriangleMesh], size: np.ndarray, path: Path
) -> tuple[OrientedBox, ...]:
    if config.collision.kind == "box":
        return (solid_box(size.tolist()),)
    if config.collision.kind == "parts":
        bounds = [(mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)) for mesh in meshes.values()]
        return tuple(
            solid_box(np.maximum(high - low, _THINNEST).tolist(), ((low + high) / 2).tolist()) for low, high in bounds
        )
    boxes = tuple(solid_box(box.size, box.centre) for box in config.collision.boxes)
    for number, box in enumerate(boxes):
        if (np.abs(box.corners()) > size / 2 + _OUTSIDE).any():
            raise ConfigError(
                f"{path}: collision[{number}]: the box leaves the object, which is {_edges(size)} m about its centre"
            )
    return boxes


def _edges(size: np.ndarray) -> str:
    return " x ".join(f"{edge:.4g}" for edge in size)


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
        if not os.path.exists(name.partition("#")[0]):
            raise ConfigError(f"{name}: there is no such file; the path is relative to the working directory")
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
