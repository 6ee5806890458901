"""Meshes that are valid files of impossible or unwieldy bodies."""

import json
import struct
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.acceptance.hostile.case import Expectation
from benchmarks.acceptance.hostile.stock import crate_mesh

_MILLIONS = 5_000_000
Body = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Shape:
    """A body and what must happen to it."""

    make: Callable[[], Body]
    expect: Expectation


def _with_vertex(value: float) -> Body:
    vertices, faces = crate_mesh()
    vertices = vertices.copy()
    vertices[3, 1] = value
    return vertices, faces


def _with_face(index: int) -> Body:
    vertices, faces = crate_mesh()
    faces = faces.copy()
    faces[2, 1] = index
    return vertices, faces


def _scaled(*factors: float) -> Body:
    vertices, faces = crate_mesh()
    return vertices * np.array(factors), faces


def _many() -> Body:
    vertices, faces = crate_mesh()
    return vertices, np.tile(faces, (_MILLIONS // len(faces) + 1, 1))


def _of_two_corners() -> Body:
    vertices, faces = crate_mesh()
    return vertices, faces[:, [0, 1, 1]]


def _duplicate_faces() -> Body:
    vertices, faces = crate_mesh()
    return vertices, np.vstack([faces, faces])


SHAPES: dict[str, Shape] = {
    "as it is": Shape(crate_mesh, "accept"),
    "a vertex is NaN": Shape(lambda: _with_vertex(np.nan), "reject"),
    "a vertex is infinite": Shape(lambda: _with_vertex(np.inf), "reject"),
    "a vertex 1e30 m away": Shape(lambda: _with_vertex(1e30), "reject"),
    "an index out of range": Shape(lambda: _with_face(999), "reject"),
    "a negative index": Shape(lambda: _with_face(-5), "reject"),
    "one triangle": Shape(lambda: (crate_mesh()[0][:3], np.array([[0, 1, 2]])), "reject"),
    "no triangle": Shape(lambda: (crate_mesh()[0], np.zeros((0, 3), int)), "reject"),
    "no vertex": Shape(lambda: (np.zeros((0, 3)), np.zeros((0, 3), int)), "reject"),
    "zero area": Shape(lambda: (crate_mesh()[0], np.zeros((12, 3), int)), "reject"),
    "triangles of two corners": Shape(_of_two_corners, "reject"),
    "flat": Shape(lambda: _scaled(1.0, 1.0, 0.0), "either"),
    "a line": Shape(lambda: _scaled(1.0, 0.0, 0.0), "reject"),
    "a point": Shape(lambda: _scaled(0.0, 0.0, 0.0), "reject"),
    "400 m long": Shape(lambda: _scaled(1000.0, 1000.0, 1000.0), "reject"),
    "0.4 mm long": Shape(lambda: _scaled(0.001, 0.001, 0.001), "reject"),
    "inside out": Shape(lambda: (crate_mesh()[0], crate_mesh()[1][:, ::-1]), "accept"),
    "half inside out": Shape(
        lambda: (crate_mesh()[0], np.vstack([crate_mesh()[1][:6], crate_mesh()[1][6:, ::-1]])), "either"
    ),
    "every face twice": Shape(_duplicate_faces, "either"),
    "a side is missing": Shape(lambda: (crate_mesh()[0], crate_mesh()[1][2:]), "either"),
    "5 million triangles": Shape(_many, "reject"),
}


def write_mesh(path: Path, name: str) -> None:
    """Write the shape called ``name`` in the format of the path's ending."""
    vertices, faces = SHAPES[name].make()
    {".obj": _write_obj, ".ply": _write_ply, ".glb": _write_glb}[path.suffix](path, vertices, faces)


def _write_obj(path: Path, vertices: np.ndarray, faces: np.ndarray) -> None:
    with path.open("w", encoding="ascii") as file:
        file.write("o crate\n")
        np.savetxt(file, vertices, fmt="v %.9g %.9g %.9g")
        np.savetxt(file, faces + 1, fmt="f %d %d %d")


def _write_ply(path: Path, vertices: np.ndarray, faces: np.ndarray) -> None:
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(vertices)}",
        *(f"property float {axis}" for axis in "xyz"),
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    rows = np.empty(len(faces), dtype=[("count", "u1"), ("indices", "<i4", 3)])
    rows["count"], rows["indices"] = 3, faces
    path.write_bytes(("\n".join(header) + "\n").encode() + vertices.astype("<f4").tobytes() + rows.tobytes())


def _write_glb(path: Path, vertices: np.ndarray, faces: np.ndarray) -> None:
    """Write the least that the glTF 2.0 specification requires; libraries would repair what is hostile."""
    points, indices = vertices.astype("<f4"), np.asarray(faces).astype("<u4")
    binary = points.tobytes() + indices.tobytes()
    content = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "crate"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": points.nbytes},
            {"buffer": 0, "byteOffset": points.nbytes, "byteLength": indices.nbytes},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": indices.size, "type": "SCALAR"},
        ],
    }
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    binary += bytes(-len(binary) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
