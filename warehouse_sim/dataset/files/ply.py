"""Triangle meshes as PLY, in the dialect that the BOP toolkit reads: type names float, int and uchar."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from warehouse_sim.dataset.files.extent import read_bytes
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.output import write_bytes

_COUNT = re.compile("[0-9]{1,9}")
_LONGEST_HEADER = 1000
_FARTHEST = 1e7
"""Largest coordinate that is read: 10 km in millimetres."""
_FACE = np.dtype([("count", "u1"), ("indices", "<i4", (3,))])
_COMMENT = "millimetres, z up, origin at the centre of the bounding box"


def ply_header(comment: str, elements: Mapping[str, tuple[int, Sequence[str]]]) -> bytes:
    """Return the header of a little-endian PLY file.

    Args:
        comment: One line on units and frame.
        elements: How many there are of each, and their properties as the file names them ("float x").
    """
    lines = ["ply", "format binary_little_endian 1.0", f"comment {comment}"]
    for name, (count, properties) in elements.items():
        lines += [f"element {name} {count}", *(f"property {item}" for item in properties)]
    return "\n".join([*lines, "end_header", ""]).encode("ascii")


def _mesh_header(vertices: int, faces: int) -> bytes:
    corners = ("float x", "float y", "float z")
    return ply_header(_COMMENT, {"vertex": (vertices, corners), "face": (faces, ["list uchar int vertex_indices"])})


def write_ply(path: Path, mesh: TriangleMesh) -> None:
    """Write positions and triangles; the unit is the caller's (BOP models are in millimetres)."""
    faces = np.empty(len(mesh.faces), dtype=_FACE)
    faces["count"], faces["indices"] = 3, mesh.faces
    header = _mesh_header(len(mesh.vertices), len(faces))
    write_bytes(path, header + mesh.vertices.astype("<f4").tobytes() + faces.tobytes(), durable=True)


def read_ply(path: Path) -> TriangleMesh:
    """Read a mesh that ``write_ply`` wrote.

    Raises:
        DatasetError: The file is missing, is laid out in another way, or holds no finite triangles of its vertices.
    """
    header, mark, body = read_bytes(path).partition(b"end_header\n")
    counts = {
        words[1]: int(words[2])
        for words in (line.split() for line in header[:_LONGEST_HEADER].decode("ascii", "replace").splitlines())
        if len(words) == 3 and words[0] == "element" and _COUNT.fullmatch(words[2])
    }
    vertices, faces = counts.get("vertex", 0), counts.get("face", 0)
    if header + mark != _mesh_header(vertices, faces) or len(body) != vertices * 12 + faces * _FACE.itemsize:
        raise DatasetError(f"{path}: is not a mesh written by this package; generate the dataset again")
    points = np.frombuffer(body, dtype="<f4", count=vertices * 3).reshape(-1, 3)
    rows = np.frombuffer(body, dtype=_FACE, offset=vertices * 12)
    counts_3, triangles = rows["count"], rows["indices"]
    if not (np.abs(points) <= _FARTHEST).all():
        raise DatasetError(f"{path}: a vertex is not finite, or {_FARTHEST:g} mm away; generate the dataset again")
    if not vertices or not faces or triangles.min() < 0 or triangles.max() >= vertices or (counts_3 != 3).any():
        raise DatasetError(f"{path}: a face is no triangle of its {vertices} vertices; generate the dataset again")
    return TriangleMesh(points.astype(np.float64), triangles.astype(np.int32))
