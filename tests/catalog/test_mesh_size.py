"""Meshes that would take gigabytes or minutes are rejected in one line, in a moment, before they are worked on."""

import json
import resource
import struct
import time
from pathlib import Path

import numpy as np
import pytest
import trimesh
from pxr import Usd, UsdGeom, Vt

from tests.catalog.test_custom import write_object
from warehouse_sim.catalog.custom import load_custom_object
from warehouse_sim.catalog.mesh_files import fans, read_parts
from warehouse_sim.errors import ConfigError

MANY = 2_000_000
SOON = 10.0
"""Seconds; on a machine of its own it takes one."""


def strip(triangles: int) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices and faces of a strip of triangles."""
    x = np.arange(triangles // 2 + 1)
    vertices = np.concatenate([np.column_stack([x, 0 * x + side, 0 * x]) for side in (0, 1)])
    a, b = x[:-1], x[:-1] + len(x)
    return vertices, np.concatenate([np.column_stack([a, a + 1, b]), np.column_stack([a + 1, b + 1, b])])


def write_obj(path: Path) -> None:
    vertices, faces = strip(MANY // 16)
    with path.open("w") as file:
        np.savetxt(file, vertices, "v %d %d %d")
        np.savetxt(file, faces + 1, "f %d %d %d")


def write_ply(path: Path) -> None:
    vertices, faces = strip(MANY)
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\nproperty float x\nproperty float y\n"
    )
    header += f"property float z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    rows = np.zeros(len(faces), [("n", "u1"), ("corners", "<i4", 3)])
    rows["n"], rows["corners"] = 3, faces
    path.write_bytes(header.encode() + vertices.astype("<f4").tobytes() + rows.tobytes())


def write_glb(path: Path) -> None:
    vertices, faces = strip(MANY)
    blob = faces.astype("<u4").tobytes() + vertices.astype("<f4").tobytes()
    split = 4 * faces.size
    views = [{"buffer": 0, "byteLength": split}, {"buffer": 0, "byteOffset": split, "byteLength": len(blob) - split}]
    views = [{"byteOffset": 0} | view for view in views]
    content = json.dumps(
        {
            "asset": {"version": "2.0"},
            "buffers": [{"byteLength": len(blob)}],
            "bufferViews": views,
            "accessors": [
                {"bufferView": 0, "componentType": 5125, "count": faces.size, "type": "SCALAR"},
                {"bufferView": 1, "componentType": 5126, "count": len(vertices), "type": "VEC3"},
            ],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 1}, "indices": 0}]}],
            "nodes": [{"mesh": 0}],
            "scenes": [{"nodes": [0]}],
        }
    ).encode()
    content += b" " * (-len(content) % 4)
    chunks = struct.pack("<I4s", len(content), b"JSON") + content + struct.pack("<I4s", len(blob), b"BIN\0") + blob
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def write_usdc(path: Path) -> None:
    vertices, faces = strip(MANY)
    stage = Usd.Stage.CreateNew(str(path))
    mesh = UsdGeom.Mesh.Define(stage, "/strip")
    mesh.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(vertices.astype(np.float32)))
    mesh.GetFaceVertexCountsAttr().Set(Vt.IntArray.FromNumpy(np.full(len(faces), 3, np.int32)))
    mesh.GetFaceVertexIndicesAttr().Set(Vt.IntArray.FromNumpy(faces.astype(np.int32).ravel()))
    stage.Save()


@pytest.mark.parametrize("write", [write_obj, write_ply, write_glb, write_usdc], ids=lambda write: write.__name__)
def test_far_too_many_triangles_are_rejected_in_a_moment(tmp_path: Path, write) -> None:
    path = tmp_path / f"strip.{write.__name__.removeprefix('write_')}"
    write(path)
    start = time.monotonic()
    with pytest.raises(
        ConfigError, match=rf"^{path.name} has [\d,]+ triangles or more; simplify it to 100,000 at most$"
    ):
        read_parts(path, None, None)
    assert time.monotonic() - start < SOON


def test_a_header_that_lies_is_rejected_before_memory_is_requested_for(tmp_path: Path) -> None:
    path = tmp_path / "a.ply"
    path.write_bytes(b"ply\nformat ascii 1.0\nelement vertex 999999999999\nproperty float x\nend_header\n0\n")
    with pytest.raises(ConfigError, match="has 999,999,999,999 vertices or more"):
        read_parts(path, None, None)


def test_a_small_glb_with_many_nodes_is_counted_as_it_is_shown(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    sphere = trimesh.creation.icosphere(subdivisions=4)  # 5,120 triangles
    for index in range(30):
        scene.add_geometry(sphere, geom_name="ball", node_name=f"n{index}", transform=np.eye(4))
    path = tmp_path / "a.glb"
    path.write_bytes(scene.export(file_type="glb"))
    with pytest.raises(ConfigError, match=f"{30 * 5120:,} triangles"):
        read_parts(path, None, None)


@pytest.mark.parametrize(
    "triangles",
    [
        "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 4\nf 1 5 5\n",  # no area at all
        "".join(
            f"v 0 {i} {i}\nv 1 {i} {i}\nv 0.5 {i} {i + 1e-10}\nf {3 * i + 1} {3 * i + 2} {3 * i + 3}\n"
            for i in range(40)
        ),
    ],
    ids=["lines", "slivers"],
)
def test_a_mesh_without_area_is_rejected_before_it_is_remeshed(tmp_path: Path, triangles: str) -> None:
    path = write_object(tmp_path)
    (tmp_path / "crate.obj").write_text(triangles)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(ConfigError, match=r"crate\.yaml: file: crate\.obj has next to no area"):
        load_custom_object(path)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 50_000  # kB


def test_a_sheet_is_rejected_since_physics_has_no_bodies_without_a_volume(tmp_path: Path) -> None:
    path = write_object(tmp_path)
    (tmp_path / "crate.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(ConfigError, match=r"each edge must be at least 0\.001 m"):
        load_custom_object(path)


@pytest.mark.parametrize("line", ["v 1 2", "v", "f 1 2 99999999999999999999", "v 1 2 x", f"f {'9' * 5001} 1 2"])
def test_a_broken_line_of_an_obj_is_named(tmp_path: Path, line: str) -> None:
    (tmp_path / "a.obj").write_text(f"v 0 0 0\n{line}\n")
    with pytest.raises(ConfigError, match=r"^a\.obj: line 2: .* cannot be read") as caught:
        read_parts(tmp_path / "a.obj", None, None)
    assert len(str(caught.value)) < 300


def test_polygons_fan_out_from_their_first_corner() -> None:
    faces = fans(np.array([4, 3, 2, 0, 5]), np.arange(14) + 10)
    expected = [(10, 11, 12), (10, 12, 13), (14, 15, 16), (19, 20, 21), (19, 21, 22), (19, 22, 23)]
    assert [tuple(face) for face in faces.tolist()] == expected
