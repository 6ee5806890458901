"""A third-party KITTI folder, written by hand or recorded, read as our own datasets are."""

import logging
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.dataset.kitti_folder import (
    BESIDE,
    CAMERA_HEIGHT,
    DONT_CARE,
    HEIGHT,
    WIDTH,
    Thing,
    project,
    street,
    write_frame,
    write_street,
)
from tests.errors import one_line
from warehouse_sim.dataset.formats.kitti.external import ExternalKittiReader
from warehouse_sim.dataset.reader import DatasetReader, is_dataset
from warehouse_sim.errors import DatasetError

POINTS_IN_CARS = [6237, 1940, 1041, 668, 53, 164]
"""Of the real frame 000008, counted by another program."""


@pytest.fixture
def root(tmp_path: Path) -> Path:
    return write_street(tmp_path / "street", 11, testing=2)


def count_in_box(points_rect: np.ndarray, words: list[str]) -> int:
    """Count the points in a row's box: turned about y, from the bottom face up."""
    h, w, le, x, y, z, heading = map(float, words[8:15])
    dx, dy, dz = (points_rect - [x, y, z]).T
    along = np.cos(heading) * dx - np.sin(heading) * dz
    across = np.sin(heading) * dx + np.cos(heading) * dz
    return int(((np.abs(along) <= le / 2) & (np.abs(across) <= w / 2) & (dy <= 0) & (dy >= -h)).sum())


def real_points(folder: Path, name: str) -> np.ndarray:
    """Return a recorded sweep in the rectified frame."""
    lines = [line.split() for line in (folder / f"calib/{name}.txt").read_text().splitlines() if line]
    rows = {words[0]: np.array(words[1:], float) for words in lines}
    velo, R0 = rows["Tr_velo_to_cam:"].reshape(3, 4), rows["R0_rect:"].reshape(3, 3)
    cloud = np.fromfile(folder / f"velodyne/{name}.bin", "<f4").reshape(-1, 4)[:, :3].astype(float)
    return (cloud @ velo[:, :3].T + velo[:, 3]) @ R0.T


@pytest.mark.real
def test_the_cars_of_a_recorded_frame_hold_their_points(real_data: Path) -> None:
    reader = ExternalKittiReader(real_data / "kitti")
    assert reader.splits == {"train": (8,), "val": (142,)}
    for split, name in (("train", "000008"), ("val", "000142")):
        (image,) = reader.images(split)
        folder = real_data / "kitti/training"
        rows = [line.split() for line in (folder / f"label_2/{name}.txt").read_text().splitlines()]
        counted = [count_in_box(real_points(folder, name), row) for row in rows if row and row[0] != "DontCare"]
        found = [len(target.geometry.model_points()) for target in image.targets]
        assert found == counted
        sweep = reader.sweep(image)
        assert np.bincount(sweep.reading.instance_ids)[1:].tolist() == counted
    assert [len(target.geometry.model_points()) for target in reader.images("train")[0].targets] == POINTS_IN_CARS


@pytest.mark.real
def test_the_labels_of_recorded_frames_lie_on_the_image(real_data: Path) -> None:
    reader = DatasetReader(real_data / "kitti")
    for image in (*reader.images("train"), *reader.images("val")):
        assert reader.rgb(image).shape == (375, 1242, 3)
        for target in image.targets:
            corners = np.array(np.meshgrid(*[(-0.5, 0.5)] * 3)).reshape(3, -1).T * target.geometry.size
            points = corners @ target.T_camera_object[:3, :3].T + target.T_camera_object[:3, 3]
            if points[:, 2].min() < 1.0 or target.visible_fraction < 0.5:
                continue
            pixels = image.camera.project(points)
            box = np.clip([*pixels.min(0), *pixels.max(0)], 0, [1241, 374] * 2)
            # People drew one and fitted the other.
            assert np.abs(box - target.box_amodal_xyxy).max() < 12.0
        assert image.T_world_camera[2, 3] == pytest.approx(1.7, abs=0.1)


def test_what_is_labelled_is_read_in_the_frame_of_the_image(root: Path) -> None:
    reader = DatasetReader(root)
    assert is_dataset(root)
    assert reader.manifest is None
    assert reader.splits == {"train": (*range(9), 10), "val": (9,), "test": (0, 1)}
    for image in reader.images("train"):
        things = street(image.scene_id, 5)
        cloud = write_frame(root / "training", image.scene_id, things, 5)
        assert [reader.objects[target.obj_id].class_name for target in image.targets] == [t.kind for t in things]
        assert [target.instance_id for target in image.targets] == [1, 2, 3]
        for target, thing in zip(image.targets, things, strict=True):
            h, w, le = thing.size
            centre = np.array([thing.x, CAMERA_HEIGHT - h / 2, thing.z]) + BESIDE
            assert np.abs(target.T_camera_object[:3, 3] - centre).max() < 1e-9
            ahead = [np.cos(thing.heading), 0, -np.sin(thing.heading)]
            assert np.allclose(
                target.T_camera_object[:3, :3], np.stack([ahead, np.cross([0, -1, 0], ahead), [0, -1, 0]], 1)
            )
            assert target.geometry.size.tolist() == [le, w, h]
            assert target.geometry.diameter == pytest.approx(np.sqrt(h**2 + w**2 + le**2))
            assert image.camera.project(centre) == pytest.approx(project(centre[None] - BESIDE)[0], abs=1e-9)
            assert len(target.geometry.model_points()) == count_in_box(cloud, thing.row().split()) >= 300


def test_frames_without_labels_are_empty(root: Path) -> None:
    reader = DatasetReader(root)
    assert [len(image.targets) for image in reader.images("test")] == [0, 0]
    for text in ("", "\n\n", f"{DONT_CARE}\n"):
        (root / "training/label_2/000003.txt").write_text(text)
        assert DatasetReader(root).images("train")[3].targets == ()
    assert reader.depth(reader.images("test")[0]).any()


def test_depth_is_the_nearest_point_of_each_pixel_and_says_so(root: Path, caplog: pytest.LogCaptureFixture) -> None:
    reader = DatasetReader(root)
    image = reader.images("train")[2]
    cloud = write_frame(root / "training", 2, street(2, 5), 5)
    slow: dict[tuple[int, int], float] = {}
    for point in cloud:
        u, v = np.rint(project(point[None])[0]).astype(int)
        if 0 <= u < WIDTH and 0 <= v < HEIGHT and point[2] > 0.1:
            slow[v, u] = min(slow.get((v, u), np.inf), point[2] + BESIDE[2])
    with caplog.at_level(logging.WARNING):
        depth = reader.depth(image)
    assert "no depth_2; depth images are the sweeps, projected" in caplog.text
    assert any("projected LiDAR" in note for note in reader._reader.notes)
    # Points that fall on the border of two pixels may fall on either, for rounding of the file.
    found = {(v, u): float(depth[v, u]) for v, u in np.argwhere(depth > 0)}
    assert len(set(found) ^ set(slow)) <= 4
    assert sum(abs(found[at] - slow[at]) > 1e-4 for at in set(found) & set(slow)) <= 2


def test_a_visible_mask_leaves_out_what_is_known_to_stand_elsewhere(root: Path) -> None:
    reader = DatasetReader(root)
    image = reader.images("train")[0]
    for target in image.targets:
        box, mask = reader.mask(image, target.gt_index), reader.mask_visible(image, target.gt_index)
        left, top, right, bottom = np.rint(target.box_amodal_xyxy).astype(int)
        assert box.sum() == (right - left + 1) * (bottom - top + 1)
        depth = reader.depth(image)
        out = box & ~mask
        assert (depth[out] > 0).all()
        assert not (mask & ~box).any()
        v, u = np.nonzero(box & (depth > 0))
        points = image.camera.rays_at(u, v) * depth[v, u][:, None]
        local = (points - target.T_camera_object[:3, 3]) @ target.T_camera_object[:3, :3]
        assert mask[v, u].sum() == (np.abs(local) <= target.geometry.size / 2).all(axis=1).sum() > 30


def test_points_that_are_no_numbers_are_dropped_and_counted(root: Path) -> None:
    path = root / "training/velodyne/000004.bin"
    cloud = np.fromfile(path, "<f4").reshape(-1, 4)
    cloud[5, 0], cloud[17, 2], cloud[30, 3] = np.nan, np.inf, -np.inf
    path.write_bytes(cloud.tobytes())
    reader = ExternalKittiReader(root)
    sweep = reader.sweep(reader.images("train")[4])
    assert len(sweep.reading.points) == len(cloud) - 3
    assert np.isfinite(sweep.reading.points).all()
    assert reader.dropped_points == {"training/velodyne/000004.bin": 3}


def test_lists_say_which_frames_belong_to_which_split(root: Path) -> None:
    (root / "ImageSets").mkdir()
    lists = {"train": [5, 2, 3], "val": [4], "trainval": [2, 3, 4, 5], "test": [1], "night": [3]}
    for name, frames in lists.items():
        (root / f"ImageSets/{name}.txt").write_text("\n".join(f"{frame:06d}" for frame in frames) + "\n\n")
    splits = DatasetReader(root).splits
    assert splits == {"train": (2, 3, 5), "val": (4,), "test": (1,), "night": (3,), "trainval": (2, 3, 4, 5)}
    (root / "ImageSets/val.txt").unlink()
    assert DatasetReader(root).splits["train"] == (2, 3)
    assert DatasetReader(root).splits["val"] == (5,)


def test_images_may_be_jpeg_or_grey(root: Path) -> None:
    for frame, ending, gray in ((0, "jpg", False), (1, "png", True), (2, "jpeg", True)):
        path = root / f"training/image_2/{frame:06d}.png"
        pixels = cv2.imread(str(path))
        path.unlink()
        shown = cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY) if gray else pixels
        cv2.imwrite(str(path.with_suffix(f".{ending}")), shown)
        reader = DatasetReader(root)
        read = reader.rgb(reader.images("train")[frame])
        assert read.shape == (HEIGHT, WIDTH, 3)
        assert not gray or (read[..., 0] == read[..., 2]).all()


def test_a_stored_depth_image_goes_before_the_sweep(root: Path) -> None:
    (root / "training/depth_2").mkdir()
    steps = np.full((HEIGHT, WIDTH), 2560, np.uint16)
    cv2.imwrite(str(root / "training/depth_2/000000.png"), steps)
    (root / "training/velodyne/000000.bin").unlink()
    reader = DatasetReader(root)
    image = reader.images("train")[0]
    assert (reader.depth(image) == 10.0).all()
    assert reader._reader.sweep(image) is None
    with pytest.raises(DatasetError, match="there is no sweep of frame 000000"):
        image.targets[0].geometry.model_points()


def test_results_unknown_classes_and_floors_are_taken(root: Path) -> None:
    path, thing = root / "training/label_2/000000.txt", Thing("Kiosk", 1.0, 9.0, 0.3)
    detected = "Car -1 -1 0.1 10 20 30 40 -1 -1 -1 -1000 -1000 -1000 -10 0.9"  # of a 2D detector
    path.write_text(f"  {thing.row()}   0.875\r\n\n{detected}\n{thing.row().replace(' 0 ', ' 0.0 ', 1)}\n")
    (root / "training/planes").mkdir()
    (root / "training/planes/000000.txt").write_text("# Matrix\nWIDTH 4\nHEIGHT 1\n0.0 -1.0 0.0 1.65 \n\n")
    reader = DatasetReader(root)
    image = reader.images("train")[0]
    assert [target.instance_id for target in image.targets] == [1, 3]
    assert reader.objects[image.targets[0].obj_id].name == "Kiosk"
    assert image.targets[0].obj_id == 9
    assert image.T_world_camera[2, 3] == pytest.approx(1.65 + BESIDE[1])
    assert image.T_world_camera[:3, 2].tolist() == pytest.approx([1, 0, 0])
    # What is to the right of the camera is to the right of the way that it looks, seen from above.
    assert image.T_world_camera[:3, 0].tolist() == pytest.approx([0, -1, 0])
    assert {info.name: number for number, info in reader.objects.items()} == {"Car": 1, "Pedestrian": 4, "Kiosk": 9}


@pytest.mark.parametrize(
    ("kind", "text", "message"),
    [
        ("label_2", "Car 0 0 1\n", "label_2/000000.txt:1: a KITTI label has 15 fields, a result 16; found 4"),
        ("label_2", "Car 0 0 0 1 2 3 4 1 1 one 1 1 9 0\n", "000000.txt:1: expected 14 numbers, found a word"),
        ("label_2", "Car 0 0 0 1 2 3 4 1 1 nan 1 1 9 0\n", "000000.txt:1: expected 14 numbers, each"),
        ("calib", "P0: 1 2 3\n", "has no line P2"),
        ("calib", "P2: 0 0 0 0 0 0 0 0 0 0 1 0\n", "P2: is no pinhole"),
        ("calib", "P2: 9 0 1 0 0 9 1 0 0 0 1 0\nTr_velo_to_cam: " + "1 " * 12, "Tr_velo_to_cam: is not a rotation"),
        ("planes", "0 -1 0 -2\n", "the floor is -2 m below the camera"),
        ("label_2_ids", "1 2\n", "must hold the id of each of 4 labels"),
    ],
)
def test_what_is_broken_is_named(root: Path, kind: str, text: str, message: str) -> None:
    (root / "training" / kind).mkdir(exist_ok=True)
    (root / f"training/{kind}/000000.txt").write_text(text)
    with one_line(DatasetError, message):
        DatasetReader(root).images("train")


def test_broken_files_and_lists_are_named(root: Path) -> None:
    (root / "ImageSets").mkdir()
    listed = root / "ImageSets/train.txt"
    for text, message in (
        ("../../etc/passwd\n", "is no number of a frame"),
        ("000077\n", "lists frame 000077, which has no calib file in training"),
        ("000001\n000001\n", "occurs twice"),
    ):
        listed.write_text(text)
        with pytest.raises(DatasetError, match=message):
            ExternalKittiReader(root)
    shutil.rmtree(root / "ImageSets")
    (root / "training/velodyne/000001.bin").write_bytes(b"12345")
    reader = ExternalKittiReader(root)
    with pytest.raises(DatasetError, match=r"000001.bin: 5 bytes are not whole rows of 4 32-bit numbers"):
        reader.depth(reader.images("train")[1])
    (root / "training/image_2/000001.png").unlink()
    with pytest.raises(DatasetError, match="there is no image of frame 000001"):
        ExternalKittiReader(root).images("train")


def test_our_own_folder_is_read_with_its_extras(toy_root: Path) -> None:
    ours, reader = DatasetReader(toy_root), DatasetReader(toy_root / "kitti")
    for split in ("train", "test"):
        pairs = {2 * image.scene_id + image.image_id: image for image in ours.images(split)}
        assert set(reader.splits[split]) == set(pairs)
        for image in reader.images(split):
            same = pairs[image.scene_id]
            assert [item.instance_id for item in image.targets] == [item.instance_id for item in same.targets]
            for target, other in zip(image.targets, same.targets, strict=True):
                assert np.abs(target.T_camera_object[:3, 3] - other.T_camera_object[:3, 3]).max() < 1e-5
                assert np.allclose(target.geometry.size, ours.objects[other.obj_id].size, atol=1e-6)
            assert np.abs(reader.depth(image) - ours.depth(same)).max() < 0.5 / 256 + 0.5 / 1000 + 1e-5
            assert (reader.rgb(image) == ours.rgb(same)).all()
            folder = toy_root / "kitti" / ("testing" if split == "test" else "training")
            stored = np.fromfile(folder / f"velodyne_ids/{image.scene_id:06d}.bin", "<i4")
            sweep = reader._reader.sweep(image)
            assert (sweep.reading.instance_ids == stored).all()
            assert sweep.reading.ring.max() == 23
            # Up is up, and the floor is where it was.
            assert image.T_world_camera[2, 3] == pytest.approx(same.T_world_camera[2, 3], abs=1e-6)
    assert DatasetReader(toy_root).manifest is not None
