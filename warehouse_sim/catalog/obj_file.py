"""Wavefront OBJ: vertices and polygons by the names of their objects; colours and other files are not read."""

from collections import defaultdict
from itertools import pairwise
from pathlib import Path

import numpy as np

from warehouse_sim.errors import ConfigError
from warehouse_sim.geometry.mesh import TriangleMesh


def read_obj(path: Path) -> dict[str, TriangleMesh]:
    """Return the meshes of the file, one for each name after ``o`` or ``g``; what has none is called as the file.

    Polygons are taken to be convex.

    Raises:
        ConfigError: A line cannot be read; the message names it.
    """
    vertices: list[list[float]] = []
    triangles: dict[str, list[tuple[int, int, int]]] = defaultdict(list)
    name = path.stem
    try:
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError as problem:
        raise ConfigError(f"{path.name} cannot be read ({problem.strerror}); check the path") from problem
    for number, line in enumerate(lines, start=1):
        key, *values = line.split() or [""]
        try:
            if key == "v":
                vertices.append([float(value) for value in values[:3]])
            elif key in ("o", "g"):
                name = " ".join(values) or path.stem
            elif key == "f":
                polygon = [_vertex(value, len(vertices)) for value in values]
                triangles[name] += [(polygon[0], *pair) for pair in pairwise(polygon[1:])]
        except ValueError as problem:
            raise ConfigError(f"{path.name}: line {number}: {line.strip()!r} cannot be read ({problem})") from problem
    return {name: _compact(np.array(vertices, float), np.array(faces, np.int32)) for name, faces in triangles.items()}


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
