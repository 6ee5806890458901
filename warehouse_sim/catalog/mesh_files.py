"""Read the parts of an object from OBJ, PLY, STL, GLB or USD, in metres and with z up."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog.mesh_size import reject_large_file, reject_many
from warehouse_sim.catalog.obj_file import read_obj
from warehouse_sim.errors import ConfigError
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.mesh_file import load_parts, placed
from warehouse_sim.geometry.pose import rotation_x, rotation_y
from warehouse_sim.optional import require

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
