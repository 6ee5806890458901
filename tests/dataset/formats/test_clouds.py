"""PLY and PCD clouds, decoded by trimesh and by a few lines of struct, and by the law of their sensors."""

import json
import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from tests.dataset import toy
from warehouse_sim.dataset.files.point_table import camera_table, sweep_table
from warehouse_sim.dataset.formats.clouds.pcd_cloud import encode_pcd, read_pcd_cloud
from warehouse_sim.dataset.formats.clouds.ply_cloud import encode_ply, read_ply_cloud
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.dataset.stored.scene_record import Outcome
from warehouse_sim.dataset.validate import validate
from warehouse_sim.errors import DatasetError
from warehouse_sim.schema.classes import CLASS_NUMBERS

READ = {"ply": read_ply_cloud, "pcd": read_pcd_cloud}
ENCODE = {"ply": encode_ply, "pcd": encode_pcd}
PCD_TYPES = {("F", "4"): "<f4", ("I", "4"): "<i4", ("U", "4"): "<u4"}


def pcd_points(path: Path) -> np.ndarray:
    """Decode a binary PCD file by its header alone."""
    head, _, body = path.read_bytes().partition(b"DATA binary\n")
    words = {line.split()[0]: line.split()[1:] for line in head.decode().splitlines() if not line.startswith("#")}
    kinds = [PCD_TYPES[pair] for pair in zip(words["TYPE"], words["SIZE"], strict=True)]
    rows = np.frombuffer(body, list(zip(words["FIELDS"], kinds, strict=True)))
    assert [str(len(rows))] == words["POINTS"] == words["WIDTH"]
    return rows


def test_a_sweep_is_that_of_the_lidar_in_its_own_frame(streams_root: Path) -> None:
    scan = toy.observe(toy.make_scene(0))[0].lidar
    assert scan is not None
    folder = streams_root / "ply" / "train" / "000000"
    vertices = trimesh.load(folder / "000000_lidar.ply").vertices
    np.testing.assert_array_equal(vertices.astype(np.float32), scan.points)
    rows = pcd_points(streams_root / "pcd" / "train" / "000000" / "000000_lidar.pcd")
    np.testing.assert_array_equal(np.stack([rows["x"], rows["y"], rows["z"]], axis=1), scan.points)
    for name in ("intensity", "ring", "time"):
        np.testing.assert_array_equal(rows[name], getattr(scan, name))
    np.testing.assert_array_equal(rows["instance_id"], scan.instance_ids)


def test_labels_are_classes_of_ids(streams_root: Path) -> None:
    rows = pcd_points(streams_root / "pcd" / "train" / "000000" / "000000_lidar.pcd")
    data = json.loads((streams_root / "pcd" / "train" / "000000" / "000000.json").read_text())
    record = json.loads((streams_root / "scenes" / "000000.json").read_text())
    classes = {item["instance_id"]: item["class_name"] for item in record["objects"]}
    assert {classes[number] for number in set(rows["instance_id"].tolist())} >= {"pallet", "carton", "floor"}
    for number in set(rows["instance_id"].tolist()):
        assert data["instances"][str(number)] == classes[number]
        assert set(rows["label"][rows["instance_id"] == number].tolist()) == {data["classes"][classes[number]]}


def test_the_cloud_of_the_camera_is_its_depth_and_colour_seen_through_its_pixels(streams_root: Path) -> None:
    observation = toy.observe(toy.make_scene(0))[0]
    rows = pcd_points(streams_root / "pcd" / "train" / "000000" / "000000_camera.pcd")
    u = np.rint(toy.CAMERA.fx * rows["x"] / rows["z"] + toy.CAMERA.cx).astype(int)
    v = np.rint(toy.CAMERA.fy * rows["y"] / rows["z"] + toy.CAMERA.cy).astype(int)
    image = np.zeros(observation.rgbd.depth.shape, np.float32)
    image[v, u] = rows["z"]
    np.testing.assert_array_equal(image, observation.rgbd.depth)
    color = np.stack([rows["rgb"] >> 16 & 255, rows["rgb"] >> 8 & 255, rows["rgb"] & 255], axis=1)
    np.testing.assert_array_equal(color, observation.rgbd.rgb[v, u])
    cloud = trimesh.load(streams_root / "ply" / "train" / "000000" / "000000_camera.ply")
    np.testing.assert_array_equal(cloud.colors[:, :3], observation.rgbd.rgb[v, u])
    # Float32 at 30 m: half of 2e-6 m.
    exact = observation.camera.rays()[v, u] * observation.rgbd.depth[v, u][:, None]
    np.testing.assert_allclose(cloud.vertices, exact, rtol=0, atol=1e-6)


def test_poses_bring_lidar_and_camera_together(streams_root: Path) -> None:
    folder = streams_root / "ply" / "train" / "000000"
    data = json.loads((folder / "000000.json").read_text())
    T_camera_lidar = np.array(data["sensors"]["lidar"]["T_camera_sensor"])
    T_world_lidar = np.array(data["T_world_camera"]) @ T_camera_lidar
    table = read_ply_cloud(folder / "000000_lidar.ply")
    points = np.stack([table["x"], table["y"], table["z"]], axis=1) @ T_world_lidar[:3, :3].T + T_world_lidar[:3, 3]
    floor = points[table["label"] == CLASS_NUMBERS["floor"]]
    assert len(floor) > 1000
    assert np.abs(floor[:, 2]).max() < 1e-5
    assert data["sensors"]["lidar"]["points"] == len(table)


@pytest.mark.parametrize("name", ["ply", "pcd"])
def test_the_reader_of_a_dataset_has_its_sweeps(tmp_path: Path, name: str) -> None:
    reader = DatasetReader(toy.make_dataset(tmp_path / "data", toy.make_manifest(formats=("bop", name))))
    for image in reader.images("val"):
        found, own = reader.sweep(image), toy.observe(toy.make_scene(image.scene_id))[image.image_id].lidar
        assert found is not None
        assert own is not None
        np.testing.assert_array_equal(found.T_camera_sensor, toy.T_CAMERA_LIDAR)
        for field in ("points", "intensity", "instance_ids", "ring", "time"):
            np.testing.assert_array_equal(getattr(found.reading, field), getattr(own, field))


def test_validate_holds_and_finds_millimetres(streams_root: Path, tmp_path: Path) -> None:
    checks = {check.name: check for check in validate(streams_root)}
    assert all(check.ok for check in checks.values()), checks
    assert {"ply files", "ply clouds", "pcd files", "pcd clouds"} <= checks.keys()
    copy = toy.make_dataset(tmp_path / "data", toy.make_manifest(formats=("ply",)))
    path = copy / "ply" / "train" / "000000" / "000000_lidar.ply"
    table = read_ply_cloud(path).copy()
    for name in "xyz":
        table[name] *= 1000.0
    path.write_bytes(encode_ply(table, "metres"))
    (problem,) = toy.failures(copy).values()
    assert str(path) in problem
    assert "metres are expected" in problem


def test_a_scene_that_was_broken_off_is_written_again(tmp_path: Path) -> None:
    store = DatasetStore(tmp_path, toy.make_manifest(formats=("ply",)))
    store.begin([toy.PALLET], toy.CAMERA)
    stray = tmp_path / "ply" / "train" / "000000" / "000099_lidar.ply"
    stray.parent.mkdir(parents=True)
    stray.write_bytes(b"half")
    toy.write_scene(store, 0)
    assert not stray.exists()


@pytest.mark.parametrize("name", ["ply", "pcd"])
def test_an_observation_without_lidar_or_objects_is_written(tmp_path: Path, name: str) -> None:
    scene = toy.make_scene(0)
    bare = [replace(item.with_reading("lidar", None), annotations=()) for item in toy.observe(scene)]
    store = DatasetStore(tmp_path, toy.make_manifest(1, (name,)))
    store.begin([toy.PALLET], toy.CAMERA)
    store.write_scene(replace(scene, instances=()), bare, Outcome({}, "none"))
    data = json.loads((tmp_path / name / "train" / "000000" / "000000.json").read_text())
    assert set(data["sensors"]) == {"camera"}
    assert data["instances"] == {}


@pytest.mark.parametrize("name", ["ply", "pcd"])
@pytest.mark.parametrize("kind", ["sweep", "camera", "empty"])
def test_a_cloud_comes_back_as_it_was(tmp_path: Path, name: str, kind: str) -> None:
    observation = toy.observe(toy.make_scene(1))[0]
    assert observation.lidar is not None
    table = camera_table(observation, {}) if kind == "camera" else sweep_table(observation.lidar, {11: "pallet"})
    table = table[:0] if kind == "empty" else table
    path = tmp_path / f"cloud.{name}"
    path.write_bytes(ENCODE[name](table, "metres"))
    found = READ[name](path)
    assert found.dtype == table.dtype
    np.testing.assert_array_equal(found, table)


def test_text_of_others_is_read(tmp_path: Path) -> None:
    ply, pcd = tmp_path / "a.ply", tmp_path / "a.pcd"
    ply.write_text(
        "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 2\nproperty double x\nproperty double y\n"
        "property double z\nproperty uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0.25 1e-3 7\n-1.5 2 3 255\n3 0 1 1\n"
    )
    found = read_ply_cloud(ply)
    assert found.tolist() == [(0.0, 0.25, 0.001, 7), (-1.5, 2.0, 3.0, 255)]
    pcd.write_text(
        "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n"
        "1 2 3\nnan nan nan\n"
    )
    rows = read_pcd_cloud(pcd)
    assert rows[0].tolist() == (1.0, 2.0, 3.0)
    assert np.isnan(rows["x"][1])


def test_the_other_order_of_bytes_is_read(tmp_path: Path) -> None:
    header = b"ply\nformat binary_big_endian 1.0\nelement vertex 1\n"
    header += b"".join(b"property float %c\n" % name for name in b"xyz") + b"end_header\n"
    (tmp_path / "a.ply").write_bytes(header + struct.pack(">3f", 1.0, -2.0, 0.5))
    assert read_ply_cloud(tmp_path / "a.ply").tolist() == [(1.0, -2.0, 0.5)]


HEAD = "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
PCD = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA "
ONE = struct.pack("<3f", 1.0, 2.0, 3.0)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.ply", HEAD.encode() + ONE, "end_header"),
        ("a.ply", (HEAD + "end_header\n").encode() + ONE[:-1], "need 12 bytes, found 11"),
        ("a.ply", HEAD.replace("vertex 1", "vertex 99999999999").encode() + b"end_header\n", "whole number"),
        ("a.ply", HEAD.replace("float z", "float y").encode() + b"end_header\n" + ONE, "each once"),
        ("a.ply", HEAD.replace("float z", "list uchar int z").encode() + b"end_header\n" + ONE, "must be a number"),
        ("a.ply", b"ply\n" + b"comment \xff\nend_header\n", "ASCII"),
        ("a.ply", b"end_header\n", "is no PLY"),
        ("a.ply", (HEAD + "end_header\n").encode() + struct.pack("<3f", np.inf, 0, 0), "x has a value beyond"),
        ("a.pcd", (PCD + "binary\n").encode() + ONE[:4], "need 12 bytes, found 4"),
        ("a.pcd", (PCD.replace("WIDTH 1", "WIDTH 3") + "binary\n").encode() + ONE, "WIDTH x HEIGHT is 3 x 1"),
        ("a.pcd", (PCD.replace("F F F", "F F") + "binary\n").encode() + ONE, "of one length"),
        ("a.pcd", (PCD + "ascii\n").encode() + b"1 2\n", "must have 3 numbers"),
        ("a.pcd", (PCD + "ascii\n").encode() + b"1 2 3\n4 5 6\n", "1 points, found 2 lines"),
        ("a.pcd", (PCD + "binary_compressed\n").encode() + struct.pack("<II", 3, 12) + b"\x20\x00\x00", "damaged"),
        ("a.pcd", b"DATA binary\n", "lacks FIELDS"),
    ],
)
def test_a_damaged_cloud_is_rejected(tmp_path: Path, name: str, content: bytes, words: str) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(DatasetError, match=words) as caught:
        READ[name[-3:]](path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
