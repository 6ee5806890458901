"""Objects that users bring, and what is said when something is wrong with them."""

import json
import os
import resource
import struct
import time
from pathlib import Path

import numpy as np
import pytest
import trimesh
import yaml
from pxr import Usd, UsdGeom, Vt

from tests.catalog.covering import volume
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.materials import materials
from warehouse_sim.catalog.mesh_files import fans, read_parts
from warehouse_sim.catalog.own_files import load_custom_object
from warehouse_sim.errors import ConfigError
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.physics import settle_scene
from warehouse_sim.physics.settle import SettleConfig
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.schema import SceneSpec

EXAMPLE = Path(__file__).parents[2] / "examples" / "custom_object" / "trolley.yaml"
SETTINGS = {"name": "crate", "class_name": "crate", "obj_id": 1001, "file": "crate.obj", "material": "kraft"}


def write_object(folder: Path, **changes: object) -> Path:
    """Store a crate of 0.4 x 0.3 x 0.2 m in some place of its file, and its YAML file with ``changes``."""
    mesh = trimesh.creation.box(extents=(0.4, 0.3, 0.2))
    mesh.apply_translation((3.0, -1.0, 0.5))
    (folder / "crate.obj").write_text("o body\n" + mesh.export(file_type="obj"))
    settings = {key: value for key, value in {**SETTINGS, **changes}.items() if value is not None}
    (folder / "crate.yaml").write_text(yaml.safe_dump(settings))
    return folder / "crate.yaml"


def test_the_worked_example_is_an_object_with_origin_at_its_centre() -> None:
    model = load_custom_object(EXAMPLE)
    assert (model.name, model.class_name, model.obj_id, model.mass) == ("tool_trolley", "trolley", 1001, 38.0)
    np.testing.assert_allclose(model.size, [0.86, 0.5, 0.91], atol=1e-9)
    vertices = model.mesh().vertices
    np.testing.assert_allclose(vertices.max(axis=0), model.size / 2, atol=1e-9)
    np.testing.assert_allclose(vertices.min(axis=0), -model.size / 2, atol=1e-9)
    assert len(model.parts) == len(model.collision) == 13
    assert {part.material for part in model.parts} == {"truck_grey", "truck_red", "rubber"} <= set(materials())
    assert len(model.symmetry) == 1
    box_volume = sum(float(np.prod(box.size)) for box in model.collision)
    assert volume(model.mesh()) == pytest.approx(box_volume)  # all parts of the trolley are boxes that look outwards


def test_defaults_give_one_collision_box_about_the_centre(tmp_path: Path) -> None:
    model = load_custom_object(write_object(tmp_path, symmetry="cuboid"))
    np.testing.assert_allclose(model.size, [0.4, 0.3, 0.2])
    (box,) = model.collision
    np.testing.assert_allclose(box.size, model.size)
    np.testing.assert_allclose(box.T_parent_box, np.eye(4))
    assert len(model.symmetry) == 4
    assert volume(model.mesh()) == pytest.approx(0.4 * 0.3 * 0.2)


def test_a_scene_takes_it_and_things_stand_on_its_upper_tray() -> None:
    trolley, draft = load_custom_object(EXAMPLE), SceneDraft()
    floor = draft.add("floor_slab", make_transform(translation=np.array([0.0, 0.0, -0.1])))
    cart = draft.add(trolley, make_transform(translation=np.array([0.0, 0.0, trolley.size[2] / 2])))
    # The upper tray's top is 0.81 m above the ground, between the handle and the other end.
    box = draft.add("carton_400x300x200", make_transform(translation=np.array([0.05, 0.0, 0.81 + 0.1])), group=1)
    spec = SceneSpec(0, 0, draft.models, materials(), (floor, cart, box), (), ())
    settled, report = settle_scene(spec, SettleConfig())
    assert report.problems == ()
    assert settled.instances[1].model == "tool_trolley"
    assert settled.instances[2].T_world_object[2, 3] == pytest.approx(0.91, abs=0.002)


@pytest.mark.parametrize(("up", "size"), [("x", (0.2, 0.3, 0.4)), ("y", (0.4, 0.2, 0.3)), ("z", (0.4, 0.3, 0.2))])
def test_the_axis_that_is_up_becomes_z(tmp_path: Path, up: str, size: tuple[float, ...]) -> None:
    model = load_custom_object(write_object(tmp_path, up=up, scale=0.5))
    np.testing.assert_allclose(model.size, np.array(size) / 2)
    assert volume(model.mesh()) == pytest.approx(0.4 * 0.3 * 0.2 / 8)


def test_turns_and_listed_boxes(tmp_path: Path) -> None:
    boxes = [{"size": [0.4, 0.3, 0.1], "centre": [0, 0, -0.05]}, {"size": [0.1, 0.1, 0.1], "centre": [0, 0, 0.05]}]
    model = load_custom_object(write_object(tmp_path, symmetry={"axis": "z", "count": 2}, collision=boxes))
    assert len(model.symmetry) == 2
    assert [box.size.tolist() for box in model.collision] == [[0.4, 0.3, 0.1], [0.1, 0.1, 0.1]]
    np.testing.assert_allclose(model.collision[1].T_parent_box[:3, 3], [0, 0, 0.05])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"widht": 1}, r"crate\.yaml: widht is not a setting"),
        ({"file": None}, r"crate\.yaml: the setting 'file' is missing"),
        ({"file": "ghost.obj"}, r"crate\.yaml: file: 'ghost\.obj' does not exist"),
        ({"file": "../crate.obj"}, r"crate\.yaml: file: '\.\./crate\.obj' leaves the folder"),
        ({"file": "/etc/hostname"}, r"crate\.yaml: file: '/etc/hostname' leaves the folder"),
        ({"file": "crate.yaml"}, r"crate\.yaml: file: crate\.yaml has the suffix '\.yaml'; known: \.obj, \.ply, \.stl"),
        ({"name": "epal1"}, r"crate\.yaml: name: 'epal1' is an object of the catalog"),
        ({"name": "My crate"}, r"crate\.yaml: name: 'My crate' must be lower case"),
        ({"obj_id": 7}, r"crate\.yaml: obj_id must be 1,000-999,999, found 7"),
        ({"mass": -1}, r"crate\.yaml: mass must be 0-20,000 kg, found -1"),
        ({"mass": "heavy"}, r"crate\.yaml: mass must be float, found 'heavy'"),
        ({"scale": 0}, r"crate\.yaml: scale must be 0.000001-1,000"),
        ({"scale": 1000}, r"crate\.yaml: scale: the object is 400 x 300 x 200 m; 0\.001 is for millimetres"),
        ({"up": "w"}, r"crate\.yaml: up must be one of 'x', 'y', 'z', found 'w'"),
        ({"material": None}, r"crate\.yaml: material: part 'body' has none"),
        ({"material": "krft"}, r"crate\.yaml: material: unknown material 'krft'; known: .*kraft"),
        ({"material": "krft", "materials": {"body": "kraft"}}, r"crate\.yaml: material: unknown material 'krft'"),
        ({"materials": {"lid": "kraft"}}, r"crate\.yaml: materials: the file has no part 'lid'; it has body"),
        ({"materials": {"body": "krft"}}, r"crate\.yaml: materials\.body: unknown material 'krft'"),
        ({"symmetry": "cubiod"}, r"crate\.yaml: symmetry: kind must be one of .* found 'cubiod'"),
        ({"symmetry": {"axis": "z", "count": 4}}, r"crate\.yaml: symmetry: turn 1 of 3 moves the surface elsewhere"),
        ({"symmetry": {"axis": "z", "count": 3}}, r"crate\.yaml: symmetry: turn 1 of 2 moves the surface elsewhere"),
        ({"symmetry": {"axis": "z", "count": 1}}, r"crate\.yaml: symmetry: count must be 2-360, found 1"),
        ({"collision": "hull"}, r"crate\.yaml: collision must be box, parts or a list of boxes"),
        ({"collision": [{"size": [1, 1, 1]}]}, r"crate\.yaml: collision\[0\]: the box leaves the object"),
        (
            {"collision": [{"sise": [1, 1, 1]}]},
            r"crate\.yaml: collision: boxes\[0\]: sise is not .* did you mean 'size'",
        ),
    ],
)
def test_what_is_wrong_is_named_by_file_and_key(tmp_path: Path, changes: dict[str, object], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        load_custom_object(write_object(tmp_path, **changes))


def test_a_missing_file_says_what_its_path_is_relative_to() -> None:
    with pytest.raises(ConfigError, match=r"crate\.yaml: there is no such file; .* relative to the working directory"):
        catalog_object("nowhere/crate.yaml")


def test_a_link_out_of_the_folder_is_rejected(tmp_path: Path) -> None:
    inside = tmp_path / "inside"
    inside.mkdir()
    path = write_object(inside, file="link.obj")
    (tmp_path / "secret.obj").write_text("v 0 0 0\n")
    os.symlink(tmp_path / "secret.obj", inside / "link.obj")
    with pytest.raises(ConfigError, match=r"crate\.yaml: file: 'link\.obj' leaves the folder"):
        load_custom_object(path)


def test_too_many_triangles_are_rejected(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("warehouse_sim.catalog.mesh_files.MAX_TRIANGLES", 11)
    with pytest.raises(
        ConfigError, match=r"crate\.yaml: file: crate\.obj has 12 triangles or more; simplify it to 11 at most"
    ):
        load_custom_object(write_object(tmp_path))


# Meshes that would take gigabytes or minutes are rejected in one line, in a moment, before they are worked on.


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
