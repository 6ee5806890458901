"""A third-party BOP folder, written here by hand, read through the same reader as our own datasets."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from warehouse_sim.dataset.object_gt import geometry_problems
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.validate import validate
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.boxes import mask_box_xyxy

WIDTH, HEIGHT, FOCAL, STEP_MM = 64, 48, 60.0, 0.1
EDGES = np.array([400.0, 300.0, 200.0])
"""Of the one object, a box (mm)."""
QUADS = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
"""Sides of a box whose corners count x fastest, seen from outside."""
CORNERS = np.array([[x, y, z] for z in (-0.5, 0.5) for y in (-0.5, 0.5) for x in (-0.5, 0.5)]) * EDGES


def ascii_ply() -> bytes:
    rows = [f"{x} {y} {z} 200 100 50" for x, y, z in CORNERS]
    rows += ["4 " + " ".join(map(str, quad)) for quad in QUADS]
    head = ["ply", "format ascii 1.0", "element vertex 8", "property double x", "property double y"]
    head += ["property double z", "property uchar red", "property uchar green", "property uchar blue"]
    head += ["element face 6", "property list uchar int vertex_indices", "end_header"]
    return "\n".join(head + rows + [""]).encode()


def big_endian_ply() -> bytes:
    head = "ply\nformat binary_big_endian 1.0\nelement vertex 8\n"
    head += "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
    head += "element face 12\nproperty list uchar uint vertex_indices\nend_header\n"
    vertices = np.hstack([CORNERS, np.ones((8, 3))]).astype(">f4").tobytes()
    triangles = [(a, b, c) for a, b, c, _ in QUADS] + [(a, c, d) for a, _, c, d in QUADS]
    rows = b"".join(b"\x03" + np.array(row, ">u4").tobytes() for row in triangles)
    return head.encode() + vertices + rows


def place(number: int) -> np.ndarray:
    """Return where the box's centre is (mm), its sides along the camera's axes."""
    return np.array([20.0 * number, 0.0, 1500.0])


def visible(number: int) -> np.ndarray:
    """Return the pixels of the near side of the box."""
    centre = place(number)
    near = centre[2] - EDGES[2] / 2
    u = (np.arange(WIDTH) - (WIDTH - 1) / 2) / FOCAL * near - centre[0]
    v = (np.arange(HEIGHT) - (HEIGHT - 1) / 2) / FOCAL * near - centre[1]
    return (np.abs(v)[:, None] <= EDGES[1] / 2) & (np.abs(u)[None, :] <= EDGES[0] / 2)


def write_scene(folder: Path, images: int, masks: bool, info: bool, gray: bool) -> None:
    """Write grey JPEG or colour PNG images, depth in tenths of a millimetre, rounded rotations, no world."""
    kind, ending = ("gray", "jpg") if gray else ("rgb", "png")
    for name in (kind, "depth", *(("mask_visib",) if masks else ())):
        (folder / name).mkdir(parents=True)
    cameras, poses, infos = {}, {}, {}
    for number in range(1, images + 1):
        shape = (HEIGHT, WIDTH) if gray else (HEIGHT, WIDTH, 3)
        cv2.imwrite(str(folder / kind / f"{number:06d}.{ending}"), np.full(shape, 80, np.uint8))
        near = place(number)[2] - EDGES[2] / 2
        depth = np.where(visible(number), near / STEP_MM, 3000.0 / STEP_MM)
        cv2.imwrite(str(folder / "depth" / f"{number:06d}.png"), depth.astype(np.uint16))
        if masks:
            path = folder / "mask_visib" / f"{number:06d}_000000.png"
            cv2.imwrite(str(path), visible(number).astype(np.uint8))
        K = [FOCAL, 0, (WIDTH - 1) / 2, 0, FOCAL, (HEIGHT - 1) / 2, 0, 0, 1]
        cameras[number] = {"cam_K": K, "depth_scale": STEP_MM}
        rounded = [0.9999, 0.0, 0.0, 0.0, 1.0, 0.0001, 0.0, 0.0, 1.0]
        poses[number] = [{"obj_id": 5, "cam_R_m2c": rounded, "cam_t_m2c": place(number).tolist()}]
        left, top, right, bottom = (int(value) for value in mask_box_xyxy(visible(number)))
        box = [left, top, right - left, bottom - top]
        infos[number] = [{"bbox_obj": box, "bbox_visib": box, "visib_fract": 1.0}]
    for name, table in (("camera", cameras), ("gt", poses), *((("gt_info", infos),) if info else ())):
        (folder / f"scene_{name}.json").write_text(json.dumps(table))


def write_folder(root: Path, mesh: bytes = b"", masks: bool = True, info: bool = True, gray: bool = True) -> Path:
    (root / "models").mkdir(parents=True)
    (root / "models" / "obj_000005.ply").write_bytes(mesh or ascii_ply())
    row = {"diameter": float(np.linalg.norm(EDGES))}
    row |= {f"min_{axis}": -edge / 2 for axis, edge in zip("xyz", EDGES, strict=True)}
    row |= {f"size_{axis}": edge for axis, edge in zip("xyz", EDGES, strict=True)}
    row |= {"symmetries_discrete": [[-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]]}
    (root / "models" / "models_info.json").write_text(json.dumps({"5": row}))
    write_scene(root / "train_pbr" / "000007", 12, masks, info, gray)
    write_scene(root / "test" / "000003", 2, masks, info, gray)
    return root


@pytest.mark.parametrize("mesh", [ascii_ply(), big_endian_ply()])
@pytest.mark.parametrize("inside", [".", "bop"])
def test_objects_come_from_the_meshes(tmp_path: Path, mesh: bytes, inside: str) -> None:
    write_folder(tmp_path / "data" / inside, mesh)
    reader = DatasetReader(tmp_path / "data")
    assert (reader.manifest, reader.name, reader.has_clean) == (None, "data", False)
    (info,) = reader.objects.values()
    assert (info.obj_id, info.name, info.class_name) == (5, "obj_000005", "object")
    assert np.allclose(info.size, EDGES / 1000.0)
    assert len(info.symmetry) == 2
    for surface in (info.mesh(), info.metric_mesh()):
        assert surface.face_areas().sum() == pytest.approx(2 * (0.12 + 0.08 + 0.06))
    assert geometry_problems(info) == []


@pytest.mark.parametrize("gray", [True, False])
def test_images_and_labels_are_in_metres_and_pixels(tmp_path: Path, gray: bool) -> None:
    reader = DatasetReader(write_folder(tmp_path / "data", gray=gray))
    assert {name: len(reader.images(name)) for name in reader.splits} == {"train": 11, "val": 1, "test": 2}
    image = reader.images("test")[1]
    (target,) = image.targets
    assert (image.scene_id, image.image_id, target.obj_id) == (3, 2, 5)
    assert reader.rgb(image).shape == (HEIGHT, WIDTH, 3)
    assert np.abs(reader.rgb(image).astype(int) - 80).max() <= 1
    depth = reader.depth(image)
    assert depth[HEIGHT // 2, WIDTH // 2] == pytest.approx(1.4)
    assert np.allclose(target.T_camera_object[:3, 3], place(2) / 1000.0)
    R = target.T_camera_object[:3, :3]
    assert np.allclose(R @ R.T, np.eye(3), atol=1e-12)
    assert np.array_equal(image.T_world_camera, np.eye(4))
    assert np.array_equal(reader.mask_visible(image, 0), visible(2))
    assert target.box_visible_xyxy == mask_box_xyxy(visible(2))
    assert {path.relative_to(reader.root).parts[0] for path in reader.files("train")} == {"train_pbr"}


def test_boxes_stand_for_masks_and_masks_give_boxes(tmp_path: Path) -> None:
    boxed = DatasetReader(write_folder(tmp_path / "boxed", masks=False))
    masked = DatasetReader(write_folder(tmp_path / "masked", info=False))
    for reader in (boxed, masked):
        image = reader.images("train")[0]
        (target,) = image.targets
        assert target.box_visible_xyxy == target.box_amodal_xyxy == mask_box_xyxy(visible(1))
        assert target.pixels_visible == target.pixels_all == np.count_nonzero(visible(1))
        assert target.visible_fraction == 1.0
        assert np.array_equal(reader.mask_visible(image, 0), visible(1))
        assert np.array_equal(reader.mask(image, 0), visible(1))


def test_without_masks_and_boxes_what_is_missing_is_named(tmp_path: Path) -> None:
    reader = DatasetReader(write_folder(tmp_path / "data", masks=False, info=False))
    with pytest.raises(DatasetError, match=r"scene_gt\.json: 1\[0\]: neither bbox_visib or bbox_obj .* mask_visib"):
        reader.images("train")


def test_test_images_need_no_labels(tmp_path: Path) -> None:
    root = write_folder(tmp_path / "data")
    for name in ("gt", "gt_info"):
        (root / "test" / "000003" / f"scene_{name}.json").unlink()
    assert [image.targets for image in DatasetReader(root).images("test")] == [(), ()]


@pytest.mark.parametrize("name", ["camera", "gt"])
def test_a_table_that_a_scene_lost_is_named_in_one_line(tmp_path: Path, name: str) -> None:
    root = write_folder(tmp_path / "data")
    write_scene(root / "test" / "000004", 2, masks=True, info=True, gray=True)
    lost = root / "test" / "000004" / f"scene_{name}.json"
    lost.unlink()
    with pytest.raises(DatasetError, match=rf"000004/scene_{name}\.json: is missing; copy the dataset again"):
        DatasetReader(root).images("test")
    assert [check.detail for check in validate(root) if not check.ok] == [f"{lost}: is missing; copy the dataset again"]


def test_a_continuous_symmetry_is_a_group_of_turns(tmp_path: Path) -> None:
    root = write_folder(tmp_path / "data")
    path = root / "models" / "models_info.json"
    table = json.loads(path.read_text())
    del table["5"]["symmetries_discrete"]
    table["5"]["symmetries_continuous"] = [{"axis": [0, 0, 1], "offset": [0, 0, 0]}]
    path.write_text(json.dumps(table))
    group = DatasetReader(root).objects[5].symmetry.transforms
    assert len(group) == 315
    assert np.array_equal(group[0], np.eye(4))
    assert np.allclose(group[1] @ group[314], np.eye(4))


@pytest.mark.parametrize(
    ("file", "content", "message"),
    [
        ("models/obj_000005.ply", b"ply\nformat ascii 1.0\n", r"obj_000005\.ply: cannot be read"),
        ("test/000003/gray/000001.jpg", b"\xff\xd8\xff", r"000001\.jpg: is a damaged JPEG image"),
        ("test/000003/depth/000001.png", b"", r"000001\.png: is not a PNG image"),
        ("test/000003/scene_gt.json", b'{"1": 3}', r"scene_gt\.json: 1: labels must be of type list"),
    ],
)
def test_what_is_damaged_is_named(tmp_path: Path, file: str, content: bytes, message: str) -> None:
    root = write_folder(tmp_path / "data")
    (root / file).write_bytes(content)
    reader = DatasetReader(root)
    with pytest.raises(DatasetError, match=message):
        (reader.objects[5].mesh(), [(reader.rgb(item), reader.depth(item)) for item in reader.images("test")])


def test_a_dataset_that_lost_its_manifest_is_not_of_others(tmp_path: Path) -> None:
    root = write_folder(tmp_path / "data")
    (root / "objects.json").write_text("{}")
    with pytest.raises(DatasetError, match="this is no dataset"):
        DatasetReader(root)
