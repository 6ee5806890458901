"""COCO and YOLO folders as others make them, and ours without what lies around them."""

import json
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.dataset.toy import make_scene, observe
from warehouse_sim.dataset.reader import DatasetReader, is_dataset
from warehouse_sim.errors import DatasetError

PHOTO = np.random.default_rng(5).integers(0, 255, (40, 60, 3), dtype=np.uint8)

ANNOTATIONS = [
    {
        **{"id": 7, "image_id": 139, "category_id": 3, "iscrowd": 0, "bbox": [10.0, 5.0, 20.0, 20.0], "area": 400.0},
        "segmentation": [[10, 5, 30, 5, 30, 25, 10, 25], [40, 30, 50.5, 30, 50, 38]],
    },
    {"id": 8, "image_id": 139, "category_id": 90, "bbox": [1.5, 2, 8, 4]},
    {
        **{"id": 9, "image_id": 139, "category_id": 3, "iscrowd": 1, "bbox": [0, 0, 60, 40], "area": 9},
        "segmentation": {"size": [40, 60], "counts": [2400]},
    },
    {
        **{"id": 10, "image_id": 139, "category_id": 3, "iscrowd": 0, "bbox": [0, 0, 2, 40], "area": 80},
        "segmentation": {"size": [40, 60], "counts": [0, 80, 2320]},
    },
]


def third_party_coco(root: Path, **changes) -> Path:
    """Write a COCO folder as one downloads it: JPEG, numbers that begin anywhere, polygons, crowds, bare boxes."""
    (root / "annotations").mkdir(parents=True)
    for split in ("train2017", "val2017"):
        (root / split).mkdir()
        cv2.imwrite(str(root / split / "000000000139.jpg"), PHOTO)
        cv2.imwrite(str(root / split / "000000000285.jpg"), PHOTO[..., 0])
        data = {
            "images": [
                {"id": 285, "file_name": "000000000285.jpg", "width": 60, "height": 40},
                {"id": 139, "file_name": "000000000139.jpg", "width": 60, "height": 40, "coco_url": "x"},
            ],
            "categories": [{"id": 3, "name": "car"}, {"id": 90, "name": "traffic light"}],
            "annotations": json.loads(json.dumps(ANNOTATIONS)),
        }
        for path, value in changes.items():
            *way, last = path.split("__")
            place = data
            for step in way:
                place = place[int(step) if step.isdecimal() else step]
            place[last] = value
        (root / "annotations" / f"instances_{split}.json").write_text(json.dumps(data))
    (root / "annotations" / "captions_val2017.json").write_text("{}")
    return root


def test_a_downloaded_coco_folder_is_read(tmp_path: Path) -> None:
    root = third_party_coco(tmp_path / "coco")
    assert is_dataset(root)
    reader = DatasetReader(root)
    assert reader.splits == {"train": (0,), "val": (1,)}
    assert {number: info.class_name for number, info in reader.objects.items()} == {3: "car", 90: "traffic light"}
    assert not reader.has_depth
    first, second = reader.images("val")
    assert [first.image_id, second.image_id] == [139, 285]
    assert (first.calibrated, second.targets) == (False, ())
    assert [target.obj_id for target in first.targets] == [3, 90, 3]
    assert not any(target.has_pose for target in first.targets)
    assert first.targets[0].box_visible_xyxy == (10, 5, 29, 24)
    assert first.targets[0].pixels_visible == 400
    assert reader.rgb(first).shape == reader.rgb(second).shape == (40, 60, 3)
    polygons, box, runs = (reader.mask_visible(first, i) for i in range(3))
    expected = np.zeros((40, 60), dtype=bool)
    expected[5:25, 10:30] = True
    assert np.array_equal(polygons[:27], expected[:27])
    assert 30 < polygons[27:].sum() < 60
    assert box.sum() == 8 * 4
    assert runs[:, :2].all()
    assert not runs[:, 2:].any()
    with pytest.raises(DatasetError, match="holds no depth images"):
        reader.depth(first)
    assert len(reader.files("val")) == 3
    assert len(reader.digest) == 64


def read_all(root: Path) -> None:
    reader = DatasetReader(root)
    for image in reader.images("train"):
        reader.rgb(image)
        for target in image.targets:
            reader.mask_visible(image, target.gt_index)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"images__0__file_name": "../../secret.jpg"}, r"without '\.\.'"),
        ({"images__0__width": 10**9}, r"images\[0\]: width must be 1 to 65535"),
        ({"images__0__id": 139}, r"two have that number|has the same number 139"),
        ({"images__0__K": [[1, 0, 0], [0, 0, 0], [0, 0, 1]]}, "K is no camera"),
        ({"annotations__0__image_id": 4}, r"annotations\[0\]: image_id 4 is not among the images"),
        ({"annotations__0__category_id": 4}, r"category_id 4 is not among the categories \[3, 90\]"),
        ({"annotations__0__bbox": [1, 2, -3, 4]}, "bbox must have a width and a height >= 0"),
        ({"annotations__0__segmentation": [[1, 2, 3, 4]]}, "a polygon must be a list of x, y"),
        ({"annotations__0__segmentation": "x"}, "must be polygons or run lengths"),
        ({"categories": {}}, "categories must be of type list"),
    ],
)  # fmt: skip
def test_wrong_coco_is_one_line(tmp_path: Path, changes: dict, says: str) -> None:
    root = third_party_coco(tmp_path / "coco", **changes)
    with pytest.raises(DatasetError, match=says):
        read_all(root)


def test_polygons_far_outside_the_image_are_cut_and_cost_nothing(tmp_path: Path) -> None:
    far = [[-1e300, -1e300, 1e300, -1e300, 1e300, 1e300, -1e300, 1e300]]
    reader = DatasetReader(third_party_coco(tmp_path / "coco", annotations__0__segmentation=far))
    assert reader.mask_visible(reader.images("train")[0], 0).all()


def test_a_table_beside_its_images_is_read(tmp_path: Path) -> None:
    made = third_party_coco(tmp_path / "made")
    for split, folder in (("train2017", "train"), ("val2017", "valid")):
        shutil.copytree(made / split, tmp_path / "export" / folder)
        shutil.copy(made / f"annotations/instances_{split}.json", tmp_path / f"export/{folder}/_annotations.coco.json")
    reader = DatasetReader(tmp_path / "export")
    assert list(reader.splits) == ["train", "val"]
    assert reader.rgb(reader.images("val")[0]).shape == (40, 60, 3)


@pytest.mark.parametrize("alone", [False, True])
def test_our_coco_comes_back_with_poses_and_cameras(images_root: Path, tmp_path: Path, alone: bool) -> None:
    root = Path(shutil.copytree(images_root, tmp_path / "data"))
    for name in ("bop", "yolo"):
        shutil.rmtree(root / name)
    if not alone:
        manifest = json.loads((root / "manifest.json").read_text()) | {"formats": ["coco"]}
        (root / "manifest.json").write_text(json.dumps(manifest))
    reader = DatasetReader(root / "coco" if alone else root)
    assert reader.splits == {"train": (0,), "val": (1,), "test": (2,)}
    other = DatasetReader(images_root)
    assert other.has_depth
    for mine, theirs in zip(reader.images("train"), other.images("train"), strict=True):
        assert (mine.scene_id, mine.image_id) == (theirs.scene_id, theirs.image_id)
        assert mine.camera == theirs.camera
        np.testing.assert_allclose(mine.T_world_camera, theirs.T_world_camera, atol=1e-12)
        assert np.array_equal(reader.rgb(mine), other.rgb(theirs))
        for a, b in zip(mine.targets, theirs.targets, strict=True):
            np.testing.assert_allclose(a.T_camera_object, b.T_camera_object, atol=1e-9)
            same = ("gt_index", "obj_id", "instance_id", "visible_fraction", "pixels_visible", "box_visible_xyxy")
            same += ("box_amodal_xyxy", "pixels_all")
            assert all(getattr(a, name) == getattr(b, name) for name in same)
            for read in ("mask", "mask_visible"):
                assert np.array_equal(getattr(reader, read)(mine, a.gt_index), getattr(other, read)(theirs, b.gt_index))


@pytest.mark.parametrize("task", ["detect", "segment", "pose", "obb"])
def test_each_task_of_our_yolo_is_a_folder_of_others(images_root: Path, task: str) -> None:
    reader = DatasetReader(images_root / "yolo" / task)
    assert {number: info.class_name for number, info in reader.objects.items()} == {1: "pallet"}
    image, empty = reader.images("train")
    seen = observe(make_scene(0))[0]
    targets = [item for item in seen.annotations if item.pixels_visible]
    assert (len(image.targets), empty.targets) == (len(targets), ())
    assert np.array_equal(reader.rgb(image), seen.rgbd.rgb)
    for target, gt in zip(image.targets, targets, strict=True):
        mask = seen.buffers.instance_mask == gt.instance_id
        if task == "segment":
            read = reader.mask_visible(image, target.gt_index)
            assert (read & mask).sum() / (read | mask).sum() > 0.95
        elif task != "obb":
            assert target.box_visible_xyxy == pytest.approx(gt.box_visible_xyxy, abs=1e-3)


def test_our_yolo_as_a_whole_is_read_by_its_polygons(images_root: Path, tmp_path: Path) -> None:
    polygons = DatasetReader(images_root / "yolo/segment")
    shutil.copytree(images_root, tmp_path / "data", ignore=shutil.ignore_patterns("bop", "coco"))
    manifest = tmp_path / "data/manifest.json"
    manifest.write_text(json.dumps(json.loads(manifest.read_text()) | {"formats": ["yolo"]}))
    reader = DatasetReader(tmp_path / "data")
    assert reader.root == tmp_path / "data/yolo"
    for mine, theirs in zip(reader.images("all"), polygons.images("all"), strict=True):
        for label in mine.targets:
            masks = (item.mask_visible(image, label.gt_index) for item, image in ((reader, mine), (polygons, theirs)))
            assert np.array_equal(*masks)


def third_party_yolo(root: Path, data: str, labels: str) -> Path:
    """Write a YOLO folder as annotation services export it."""
    for split in ("train", "valid"):
        (root / split / "images").mkdir(parents=True)
        (root / split / "labels").mkdir()
        cv2.imwrite(str(root / split / "images" / "a.jpg"), PHOTO)
        cv2.imwrite(str(root / split / "images" / "b.png"), PHOTO)
        (root / split / "labels" / "a.txt").write_text(labels)
    (root / "data.yaml").write_text(data)
    return root


EXPORTED = "train: ../train/images\nval: ../valid/images\ntest: ../test/images\nnc: 2\nnames: [person, dog]\n"


def test_an_exported_yolo_folder_is_read(tmp_path: Path) -> None:
    root = third_party_yolo(tmp_path / "yolo", EXPORTED, "1 0.5 0.5 0.2 0.5\n\n0 0.1 0.1 0.5 0.1 0.5 0.5 0.1 0.5\n")
    reader = DatasetReader(root)
    assert {number: info.class_name for number, info in reader.objects.items()} == {1: "person", 2: "dog"}
    image, empty = reader.images("val")
    assert [target.obj_id for target in image.targets] == [2, 1]
    assert image.targets[0].box_visible_xyxy == pytest.approx((24, 10, 35, 29))
    assert reader.mask_visible(image, 0).sum() == 12 * 20
    assert empty.targets == ()
    with pytest.raises(DatasetError, match=r"test is .*, which is no folder"):
        reader.images("test")


@pytest.mark.parametrize(
    ("data", "labels", "says"),
    [
        (EXPORTED, "2 0.5 0.5 0.1 0.1\n", r"a.txt:1: class 2 is not in data.yaml, which has 2 classes"),
        (EXPORTED, "0 0.5 0.5 1.5 0.1\n", "must be fractions of the image, 0 to 1"),
        (EXPORTED, "0 0.5 0.5 0.5\n", "has 4 numbers; a box has 5"),
        (EXPORTED, "pallet 0.5 0.5 0.5 0.5\n", "must be numbers"),
        (f"{EXPORTED}kpt_shape: [1, 3]\n", "0 0.5 0.5 0.5 0.5 0.5 0.5 7\n", "flags of key points must be 0, 1 or 2"),
        (EXPORTED.replace("[person, dog]", "3"), "", "names must list the classes"),
        ("names: [a]\ntrain: ../../../etc\nval: x\n", "", r"without '\.\.'"),
        ("names: [a]\ntrain: [a, b]\n", "", "train must be one folder"),
        ("names: [a]\ntrain: x\nkpt_shape: [2]\n", "", "kpt_shape must be"),
    ],
)
def test_wrong_yolo_is_one_line(tmp_path: Path, data: str, labels: str, says: str) -> None:
    with pytest.raises(DatasetError, match=says):
        DatasetReader(third_party_yolo(tmp_path / "yolo", data, labels)).images("train")
