"""Wavefront OBJ: vertices and polygons by the names of their objects; colours and other files are not read."""

from collections import defaultdict
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np

from warehouse_sim.catalog.mesh_size import reject_many
from warehouse_sim.errors import ConfigError, shown
from warehouse_sim.geometry.mesh import TriangleMesh


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
