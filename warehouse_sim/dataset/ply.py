"""Triangle meshes as PLY, in the dialect that the BOP toolkit reads: type names float, int and uchar."""

from pathlib import Path

import numpy as np

from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.output import write_bytes

_FACE = np.dtype([("count", "u1"), ("indices", "<i4", (3,))])
_HEADER = """ply
format binary_little_endian 1.0
comment millimetres, z up, origin at the centre of the bounding box
element vertex {vertices}
property float x
property float y
property float z
element face {faces}
property list uchar int vertex_indices
end_header
"""


def write_ply(path: Path, mesh: TriangleMesh) -> None:
    """Write positions and triangles; the unit is the caller's (BOP models are in millimetres)."""
    faces = np.empty(len(mesh.faces), dtype=_FACE)
    faces["count"], faces["indices"] = 3, mesh.faces
    header = _HEADER.format(vertices=len(mesh.vertices), faces=len(faces)).encode("ascii")
    write_bytes(path, header + mesh.vertices.astype("<f4").tobytes() + faces.tobytes(), durable=True)


def read_ply(path: Path) -> TriangleMesh:
    """Read a mesh that ``write_ply`` wrote.

    Raises:
        DatasetError: The file is missing or is laid out in another way.
    """
    try:
        content = path.read_bytes()
    except OSError as problem:
        raise DatasetError(f"{path}: cannot be read ({problem.strerror}); the dataset is incomplete") from problem
    header, mark, body = content.partition(b"end_header\n")
    counts = {
        words[1]: int(words[2])
        for words in (line.split() for line in header.decode("ascii", "replace").splitlines())
        if len(words) == 3 and words[0] == "element" and words[2].isdigit()
    }
    vertices, faces = counts.get("vertex", 0), counts.get("face", 0)
    expected = _HEADER.format(vertices=vertices, faces=faces).encode("ascii")
    if header + mark != expected or len(body) != vertices * 12 + faces * _FACE.itemsize:
        raise DatasetError(f"{path}: is not a mesh written by this package; generate the dataset again")
    points = np.frombuffer(body, dtype="<f4", count=vertices * 3).reshape(-1, 3)
    triangles = np.frombuffer(body, dtype=_FACE, offset=vertices * 12)["indices"]
    return TriangleMesh(points.astype(np.float64), triangles.astype(np.int32))
