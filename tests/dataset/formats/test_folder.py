"""Bare folders of colour, depth, intrinsics and masks: made here, and one that was recorded."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import DatasetError, EvaluationError, WarehouseSimError
from warehouse_sim.evaluation import evaluate

H, W = 24, 32


def write(path: Path, image: np.ndarray) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), image)


def write_flat(root: Path, ending: str = ".png") -> Path:
    write(root / f"color_image{ending}", np.full((H, W, 3), (10, 20, 30), np.uint8))
    write(root / "raw_depth.png", np.full((H, W), 1500, np.uint16))
    for number in (2, 10, 1):
        mask = np.zeros((H, W), np.uint16)
        mask[: number + 1] = 1570
        write(root / f"box_mask_{number}.png", mask)
    (root / "intrinsics.json").write_text(json.dumps({"width": W, "height": H, "fx": 30, "fy": 31, "cx": 15, "cy": 12}))
    return root


def test_images_without_intrinsics_are_told_what_they_lack(tmp_path: Path) -> None:
    root = write_flat(tmp_path / "boxes")
    (root / "intrinsics.json").unlink()
    with pytest.raises(DatasetError, match="nothing says what the camera is; put intrinsics"):
        DatasetReader(root)
    (root / "raw_depth.png").unlink()
    with pytest.raises(DatasetError, match="this is no dataset"):
        DatasetReader(root)


def test_one_image_with_its_masks_in_order_of_their_numbers(tmp_path: Path) -> None:
    reader = DatasetReader(write_flat(tmp_path / "boxes"))
    (image,) = reader.images("test")
    assert [target.has_pose for target in image.targets] == [False] * 3
    assert [target.pixels_visible for target in image.targets] == [2 * W, 3 * W, 11 * W]
    assert (image.camera.width, image.camera.height, image.camera.fx, image.camera.cy) == (W, H, 30.0, 12.0)
    assert reader.rgb(image)[0, 0].tolist() == [30, 20, 10]
    assert np.allclose(reader.depth(image), 1.5)
    assert [int(reader.mask_visible(image, i)[:, 0].sum()) for i in range(3)] == [2, 3, 11]
    assert [path.name for path in reader.files("test")] == [
        "box_mask_1.png",
        "box_mask_10.png",
        "box_mask_2.png",
        "color_image.png",
        "intrinsics.json",
        "raw_depth.png",
    ]
    assert len(reader.digest) == 64


def test_many_images_in_folders_with_a_matrix_in_a_text_file(tmp_path: Path) -> None:
    for number in (7, 8, 12):
        write(tmp_path / "rgb" / f"{number}.jpg", np.full((H, W), 9 * number, np.uint8))
        write(tmp_path / "depth" / f"{number:04d}.tif", np.full((H, W), 100 * number, np.uint16))
    write(tmp_path / "masks" / "8_0.png", np.ones((H, W, 3), np.uint8))
    (tmp_path / "K.txt").write_text("30 0 15\n0 31 12\n0 0 1\n")
    reader = DatasetReader(tmp_path)
    images = reader.images("test")
    assert [len(image.targets) for image in images] == [0, 1, 0]
    assert [float(reader.depth(image)[0, 0]) for image in images] == pytest.approx([0.7, 0.8, 1.2])
    assert [round(float(reader.rgb(image).mean()) / 9) for image in images] == [7, 8, 12]


def test_other_ways_to_write_the_camera(tmp_path: Path) -> None:
    root = write_flat(tmp_path)
    row = {"cam_K": [30, 0, 15, 0, 31, 12, 0, 0, 1], "depth_scale": 0.1}
    (root / "intrinsics.json").write_text(json.dumps(row))
    (root / "cam2world.json").write_text(
        json.dumps({"cam2world": [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]})
    )
    reader = DatasetReader(root)
    (image,) = reader.images("test")
    assert image.camera.fy == 31.0
    assert image.T_world_camera[:3, 3].tolist() == [1.0, 2.0, 3.0]
    assert reader.depth(image)[0, 0] == pytest.approx(0.15)
    # The other file leads the other way: a quarter turn back, and its shift seen from the turned frame.
    (root / "cam2world.json").rename(root / "cam2root.json")
    (image,) = DatasetReader(root).images("test")
    assert image.T_world_camera.tolist() == [[0, 1, 0, -2], [-1, 0, 0, 1], [0, 0, 1, -3], [0, 0, 0, 1]]


@pytest.mark.parametrize(
    ("break_it", "message"),
    [
        (lambda root: (root / "intrinsics.json").write_text('{"fx": 1e9}'), r"intrinsics\.json: fx must be"),
        (lambda root: (root / "intrinsics.json").write_text('{"K": [[1, 2], [3]]}'), r"K must be 9 numbers"),
        (lambda root: write(root / "depth_2.png", np.ones((H, W), np.uint16)), "1 colour images .* and 2 depth images"),
        (lambda root: write(root / "raw_depth.png", np.ones((H, W, 3), np.uint8)), "expected depth in one channel"),
        (lambda root: write(root / "raw_depth.png", np.ones((H, 9), np.uint16)), r"depth of image 0 is \(24, 9\)"),
        (lambda root: write(root / "color.png", np.ones((9, 9, 3), np.uint8)), "2 colour images"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, break_it, message: str) -> None:
    root = write_flat(tmp_path / "data")
    break_it(root)
    reader = DatasetReader(root)
    with pytest.raises(WarehouseSimError, match=message):
        reader.depth(reader.images("test")[0])


def test_evaluate_says_that_there_are_no_poses(tmp_path: Path) -> None:
    root = write_flat(tmp_path / "data")
    csv = tmp_path / "ours_data-test.csv"
    csv.write_text("scene_id,im_id,obj_id,score,R,t,time\n")
    with pytest.raises(EvaluationError, match=r"has no poses to score against: 1 images, 3 bare masks; predict and"):
        evaluate(csv, root, "test")
    with pytest.raises(DatasetError, match="there is no split 'train'; known: test"):
        DatasetReader(root).images("train")


@pytest.mark.real
def test_recorded_cartons(real_data: Path) -> None:
    """Back-projected, the masked pixels of each carton are about as large as cartons of 255 x 155 x 100 mm."""
    reader = DatasetReader(real_data / "boxes")
    (image,) = reader.images("test")
    assert (len(image.targets), image.camera.width, image.camera.height) == (11, 640, 480)
    depth = reader.depth(image)
    assert 0.5 < np.median(depth[depth > 0]) < 2.5
    for number in range(len(image.targets)):
        mask = reader.mask_visible(image, number) & (depth > 0)
        points = image.camera.rays()[mask] * depth[mask][:, None]
        near = points[np.abs(points - np.median(points, axis=0)).max(axis=1) < 0.3]
        spread = np.linalg.norm(np.ptp(np.percentile(near, [5, 95], axis=0), axis=0))
        assert 0.08 < spread < 0.33, (number, spread)
    assert np.linalg.norm(image.T_world_camera[:3, 3]) > 1.0


@pytest.mark.real
def test_a_recorded_frame_of_linemod_needs_intrinsics_beside_it(real_data: Path, tmp_path: Path) -> None:
    """Its surface points, posed and projected, fall into its mask, which the door reads."""
    source = real_data / "linemod_cat"
    for name, other in (("cat.jpg", "rgb.jpg"), ("depth.png", "depth.png"), ("cat_mask.png", "mask.png")):
        (tmp_path / other).write_bytes((source / name).read_bytes())
    (tmp_path / "K.txt").write_text("572.4114 0 325.2611 0 573.57043 242.04899 0 0 1")
    reader = DatasetReader(tmp_path)
    (image,) = reader.images("test")
    mask, T = reader.mask_visible(image, 0), np.load(source / "cat_pose.npy", allow_pickle=False)
    points = np.loadtxt(source / "cat_points_3d.txt") @ T[:, :3].T + T[:, 3]
    u, v = np.rint(
        points[:, :2] / points[:, 2:] * [image.camera.fx, image.camera.fy] + [image.camera.cx, image.camera.cy]
    ).T
    # The points are the outermost ones of the surface: they lie on the rim of the mask, drawn by hand.
    grown = cv2.dilate(mask.astype(np.uint8), np.ones((11, 11), np.uint8))
    assert grown[v.astype(int), u.astype(int)].all()
    seen = reader.depth(image)[mask & (reader.depth(image) > 0)]
    assert abs(np.median(seen) - np.median(points[:, 2])) < 0.1


@pytest.mark.real
def test_the_floor_of_the_recorded_cartons_is_level(real_data: Path) -> None:
    reader = DatasetReader(real_data / "boxes")
    (image,) = reader.images("test")
    depth = reader.depth(image)
    v, u = np.nonzero(depth > 0)
    rng = np.random.default_rng(0)
    chosen = rng.choice(len(u), 6000)
    points = image.camera.rays_at(u[chosen], v[chosen]) * depth[v[chosen], u[chosen]][:, None]
    planes = []
    for _ in range(500):  # the largest plane is the floor's
        a, b, c = points[rng.choice(len(points), 3)]
        normal = np.cross(b - a, c - a) / max(np.linalg.norm(np.cross(b - a, c - a)), 1e-9)
        planes.append((np.count_nonzero(np.abs((points - a) @ normal) < 0.008), *normal))
    up = image.T_world_camera[:3, :3] @ np.array(max(planes)[1:])
    assert np.degrees(np.arccos(abs(up[2]))) < 1.5
