"""Read the parts of an object from OBJ, PLY, STL, GLB or USD, in metres and with z up."""

import json
import re
import struct
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np
from jaxtyping import Float

from warehouse_sim.errors import ConfigError, shown
from warehouse_sim.geometry.mesh import TriangleMesh, load_parts, placed
from warehouse_sim.geometry.pose import rotation_x, rotation_y
from warehouse_sim.optional import require

MAX_TRIANGLES = 100_000
"""More would slow every renderer and ray caster down without showing in an image."""
MAX_VERTICES = 3 * MAX_TRIANGLES
"""As many as that many triangles can have."""
_MOST_BYTES = 200_000_000
_MOST_HEADER_BYTES = 20_000_000


def reject_large_file(path: Path) -> None:
    """Reject a mesh file that is too large, or whose header declares too many vertices or triangles.

    Raises:
        ConfigError: It is too large, or its header cannot be read.
    """
    size = path.stat().st_size
    if size > _MOST_BYTES:
        raise ConfigError(
            f"{path.name} has {size // 1_000_000} MB, at most {_MOST_BYTES // 1_000_000} are read; simplify it"
        )
    count = {".ply": _ply_counts, ".glb": _glb_counts}.get(path.suffix.lower())
    if count is not None:
        try:
            vertices, triangles = count(path)
        except (ValueError, LookupError, TypeError, AttributeError, RecursionError, struct.error) as problem:
            raise ConfigError(f"{path.name} cannot be read (its header is broken); export it again") from problem
        reject_many(path.name, vertices, triangles)


def reject_many(name: str, vertices: int, triangles: int) -> None:
    """Reject more vertices or triangles than an object may have.

    Raises:
        ConfigError: There are more.
    """
    if triangles > MAX_TRIANGLES:
        raise ConfigError(f"{name} has {triangles:,} triangles or more; simplify it to {MAX_TRIANGLES:,} at most")
    if vertices > MAX_VERTICES:
        raise ConfigError(f"{name} has {vertices:,} vertices or more; simplify it to {MAX_VERTICES:,} at most")


def _ply_counts(path: Path) -> tuple[int, int]:
    """Return the vertices and faces that the header announces."""
    with path.open("rb") as file:
        header = file.read(65_536).partition(b"end_header")[0]
    counts = {name: int(number) for name, number in re.findall(rb"element\s+(vertex|face)\s+(\d{1,18})\s", header)}
    return counts[b"vertex"], counts.get(b"face", 0)


def _glb_counts(path: Path) -> tuple[int, int]:
    """Return the vertices and triangles of all meshes, each as often as a node shows it (glTF 2.0, 3.7 and 4.4)."""
    with path.open("rb") as file:
        length, _ = struct.unpack("<12xI4s", file.read(20))
        if length > _MOST_HEADER_BYTES:
            raise ValueError(f"a description of {length} bytes")
        content: dict[str, Any] = json.loads(file.read(length))
    accessors = [int(item["count"]) for item in content.get("accessors", [])]
    vertices = triangles = 0
    for node in content.get("nodes", []):
        for part in content["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
            corners = accessors[part["attributes"]["POSITION"]]
            vertices += corners
            triangles += (accessors[part["indices"]] if "indices" in part else corners) // 3
    return vertices, triangles


def read_obj(path: Path) -> dict[str, TriangleMesh]:
    """Return the meshes of the file, one for each name after ``o`` or ``g``; what has none is called as the file.

    Polygons are taken to be convex.

    Raises:
        ConfigError: A line cannot be read, and the message names it, or there are too many triangles.
    """
    vertices: list[list[float]] = []
    triangles: dict[str, list[tuple[int, int, int]]] = defaultdict(list)
    name = path.stem
    count = 0
    for number, line in _lines(path):
        key, *values = line.split() or [""]
        try:
            if key == "v":
                x, y, z = map(float, values[:3])
                vertices.append([x, y, z])
            elif key in ("o", "g"):
                name = " ".join(values) or path.stem
            elif key == "f":
                polygon = [_vertex(value, len(vertices)) for value in values]
                triangles[name] += [(polygon[0], *pair) for pair in pairwise(polygon[1:])]
                count += max(len(polygon) - 2, 0)
        except ValueError as problem:
            raise ConfigError(
                f"{path.name}: line {number}: {shown(line.strip())} cannot be read ({problem})"
            ) from problem
        reject_many(path.name, len(vertices), count)
    return {name: _compact(np.array(vertices, float), np.array(faces, np.int32)) for name, faces in triangles.items()}


def _lines(path: Path) -> Iterator[tuple[int, str]]:
    """Yield the lines of a file with their numbers, from 1."""
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            yield from enumerate(file, start=1)
    except OSError as problem:
        raise ConfigError(f"{path.name} cannot be read ({problem.strerror}); check the path") from problem


def _vertex(corner: str, count: int) -> int:
    """Return the index, from 0, of the vertex of a corner like ``7``, ``7/1/3`` or ``-2``."""
    number = int(corner.partition("/")[0])
    index = number - 1 if number > 0 else count + number
    if number == 0 or not 0 <= index < count:
        raise ValueError(f"there is no vertex {number} yet")
    return index


def _compact(vertices: np.ndarray, faces: np.ndarray) -> TriangleMesh:
    """Return a mesh with only the vertices that it uses."""
    used, renumbered = np.unique(faces, return_inverse=True)
    return TriangleMesh(vertices[used], renumbered.reshape(-1, 3).astype(np.int32))


Up = Literal["x", "y", "z"]
_Z_UP = {"x": rotation_y(-np.pi / 2), "y": rotation_x(np.pi / 2), "z": np.eye(3)}


@dataclass(frozen=True, eq=False)
class MeshFile:
    """What a file holds, in its own units and axes."""

    parts: dict[str, TriangleMesh]
    """Meshes by their names in the file."""
    up: Up
    """The axis that the format, or the file itself, says is up."""
    scale: float
    """Metres of one unit."""


def read_parts(path: Path, up: Up | None, scale: float | None) -> dict[str, TriangleMesh]:
    """Return the named meshes of the file in metres, z up.

    Args:
        path: A file whose suffix is one of ``SUFFIXES``.
        up: Axis of the file that points up; what the file or its format says when None.
        scale: Metres of one unit of the file; what the file says, or 1, when None.

    Raises:
        ConfigError: The file cannot be read, has another suffix, or holds no triangles, broken ones or too many.
        MissingPackageError: The package that reads this format is not installed.
    """
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise ConfigError(f"{path.name} has the suffix {path.suffix!r}; known: {', '.join(SUFFIXES)}")
    reject_large_file(path)
    content = reader(path)
    reject_many(
        path.name,
        max(len(mesh.vertices) for mesh in content.parts.values()) if content.parts else 0,
        sum(len(mesh.faces) for mesh in content.parts.values()),
    )
    parts = {name: mesh for name, mesh in content.parts.items() if len(mesh.faces)}
    if not parts:
        raise ConfigError(f"{path.name} holds no triangles; export it with its meshes")
    turn = _Z_UP[content.up if up is None else up] * (content.scale if scale is None else scale)
    return {name: _turned(path, name, mesh, turn) for name, mesh in parts.items()}


def _turned(path: Path, name: str, mesh: TriangleMesh, turn: Float[np.ndarray, "3 3"]) -> TriangleMesh:
    if not np.isfinite(mesh.vertices).all():
        raise ConfigError(f"{path.name}: part {name!r} has vertices that are not finite; repair and export it again")
    if mesh.faces.min() < 0 or mesh.faces.max() >= len(mesh.vertices):
        raise ConfigError(f"{path.name}: part {name!r} has faces that name vertices which do not exist")
    return TriangleMesh(mesh.vertices @ turn.T, mesh.faces)


def _read_obj(path: Path) -> MeshFile:
    return MeshFile(read_obj(path), "z", 1.0)


def _read_ply(path: Path) -> MeshFile:
    return MeshFile(_read_with_trimesh(path), "z", 1.0)


def _read_glb(path: Path) -> MeshFile:
    return MeshFile(_read_with_trimesh(path), "y", 1.0)  # glTF 2.0, section 3.4: y up, metres


def _read_with_trimesh(path: Path) -> dict[str, TriangleMesh]:
    try:
        return {name: placed(*part) for name, part in load_parts(path).items()}
    except ValueError as problem:
        raise ConfigError(f"{path.name} cannot be read ({problem}); export it again") from problem


def _read_usd(path: Path) -> MeshFile:
    usd, geom = (require(f"pxr.{name}", "interchange", "to read USD files") for name in ("Usd", "UsdGeom"))
    try:
        stage = usd.Stage.Open(str(path))
    except Exception as problem:  # the bindings' own error class cannot be imported without them
        raise ConfigError(f"{path.name} cannot be read ({' '.join(str(problem).split())[:200]})") from problem
    for layer in stage.GetUsedLayers():
        if layer.realPath and not Path(layer.realPath).resolve().is_relative_to(path.parent.resolve()):
            raise ConfigError(
                f"{path.name} refers to {layer.realPath}, outside its folder; flatten the stage into one file"
            )
    parts, triangles = {}, 0
    for prim in stage.Traverse(usd.TraverseInstanceProxies()):
        if prim.IsA(geom.Mesh):
            mesh = geom.Mesh(prim)
            counts, corners = (
                np.array(item.Get() or (), int)
                for item in (mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr())
            )
            triangles += len(corners) // 3
            reject_many(path.name, 0, triangles)
            if counts.min(initial=0) < 0 or counts.sum() != len(corners):
                raise ConfigError(f"{path.name}: {prim.GetPath()} has other corners than its polygons; export it again")
            faces = fans(counts, corners)
            if mesh.GetOrientationAttr().Get() == geom.Tokens.leftHanded:
                faces = faces[:, ::-1]
            # USD multiplies row vectors from the left, so its matrices are the transpose of ours.
            T_file_part = np.array(geom.Xformable(prim).ComputeLocalToWorldTransform(usd.TimeCode.Default())).T
            points = np.array(mesh.GetPointsAttr().Get() or (), float).reshape(-1, 3)
            name = prim.GetName() if prim.GetName() not in parts else str(prim.GetPath())
            parts[name] = placed(TriangleMesh(points, faces), T_file_part)
    up: Up = "y" if geom.GetStageUpAxis(stage) == geom.Tokens.y else "z"
    return MeshFile(parts, up, float(geom.GetStageMetersPerUnit(stage)))


def fans(counts: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Cut convex polygons into triangles that share their first corner.

    Args:
        counts: Corners of each polygon.
        corners: Vertex indices of all polygons, one after the other.
    """
    each = np.maximum(counts - 2, 0)
    first = np.repeat(np.cumsum(counts) - counts, each)
    step = np.arange(each.sum()) - np.repeat(np.cumsum(each) - each, each)
    return corners[np.stack([first, first + step + 1, first + step + 2], axis=1)].astype(np.int32)


_READERS: dict[str, Callable[[Path], MeshFile]] = {
    ".obj": _read_obj,
    ".ply": _read_ply,
    ".stl": _read_ply,
    ".glb": _read_glb,
    **dict.fromkeys((".usd", ".usda", ".usdc", ".usdz"), _read_usd),
}
SUFFIXES = tuple(_READERS)
"""What files may be called."""
