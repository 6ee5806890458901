"""What is odd about the folders that BOP distributes: names of folders, kinds of files, what is missing, shards."""

import io
import json
import logging
import shutil
import tarfile
from pathlib import Path

import cv2
import numpy as np
import pytest
from pycocotools import mask as coco_mask

from tests.dataset.formats.test_external_bop import HEIGHT, WIDTH, place, visible, write_folder, write_scene
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.boxes import mask_box_xyxy


def edit(path: Path, change) -> None:
    data = json.loads(path.read_text())
    path.write_text(json.dumps(change(data) or data))


def test_tless_has_two_kinds_of_models_and_two_of_training(tmp_path: Path) -> None:
    root = write_folder(tmp_path / "tless")
    (root / "models").rename(root / "models_reconst")
    shutil.copytree(root / "models_reconst", root / "models_cad")
    (root / "models_reconst" / "obj_000005.ply").write_bytes(b"the worse one")
    shutil.copytree(root / "train_pbr", root / "train_primesense")
    (root / "test").rename(root / "test_primesense")
    reader = DatasetReader(root)
    assert list(reader.splits) == ["train", "test", "val", "train_primesense"]
    assert reader.objects[5].mesh().face_areas().sum() > 0
    assert len(reader.images("test")) == 2
    assert len(reader.images("train_primesense")) == 12


def test_only_models_for_evaluation_and_no_table_of_them(tmp_path: Path) -> None:
    root = write_folder(tmp_path / "data")
    (root / "models").rename(root / "models_eval")
    (root / "models_eval" / "models_info.json").unlink()
    (info,) = DatasetReader(root).objects.values()
    assert np.allclose(info.size, [0.4, 0.3, 0.2])
    assert info.diameter == pytest.approx(np.linalg.norm([0.4, 0.3, 0.2]))
    assert len(info.symmetry) == 1


def test_itodd_is_grey_tiff_without_masks_and_without_labels_on_test(tmp_path: Path) -> None:
    root = write_folder(tmp_path / "itodd", masks=False)
    shutil.rmtree(root / "train_pbr")
    write_scene(root / "val" / "000001", 2, masks=False, info=True, gray=True)
    for folder in (root / "val" / "000001", root / "test" / "000003"):
        for kind in ("gray", "depth"):
            for path in sorted((folder / kind).iterdir()):
                cv2.imwrite(str(path.with_suffix(".tif")), cv2.imread(str(path), cv2.IMREAD_UNCHANGED))
                path.unlink()
    for name in ("gt", "gt_info"):
        (root / "test" / "000003" / f"scene_{name}.json").unlink()
    reader = DatasetReader(root)
    assert [image.targets for image in reader.images("test")] == [(), ()]
    image = reader.images("val")[0]
    assert reader.rgb(image).shape == (HEIGHT, WIDTH, 3)
    assert reader.depth(image)[HEIGHT // 2, WIDTH // 2] == pytest.approx(1.4)
    assert np.array_equal(reader.mask_visible(image, 0), visible(1))


def test_train_pbr_is_jpeg_and_scales_and_cameras_differ_from_image_to_image(tmp_path: Path) -> None:
    root = write_folder(tmp_path / "ycbv", gray=False)
    scene = root / "train_pbr" / "000007"
    for path in sorted((scene / "rgb").iterdir()):
        cv2.imwrite(str(path.with_suffix(".jpg")), cv2.imread(str(path)))
        path.unlink()

    def other(table: dict) -> None:
        table["2"]["depth_scale"] = 0.2
        table["2"]["cam_K"][2] += 3.5
        del table["3"]["depth_scale"]

    edit(scene / "scene_camera.json", other)
    reader = DatasetReader(root)
    images = reader.images("train")
    depths = [float(reader.depth(image)[HEIGHT // 2, WIDTH // 2]) for image in images[:3]]
    assert depths == pytest.approx([1.4, 2.8, 14.0])
    assert images[1].camera.cx - images[0].camera.cx == pytest.approx(3.5)
    assert reader.rgb(images[0]).shape == (HEIGHT, WIDTH, 3)


def test_empty_frames_hidden_objects_and_objects_without_mesh(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    root = write_folder(tmp_path / "data", info=False)
    scene = root / "test" / "000003"
    hidden = np.zeros((HEIGHT, WIDTH), np.uint8)
    cv2.imwrite(str(scene / "mask_visib" / "000001_000001.png"), hidden)

    def more(table: dict) -> None:
        table["1"].append(dict(table["1"][0]))
        table["1"].insert(0, {**table["1"][0], "obj_id": 99})
        table["2"] = []

    edit(scene / "scene_gt.json", more)
    (scene / "mask_visib" / "000001_000001.png").rename(scene / "mask_visib" / "000001_000002.png")
    (scene / "mask_visib" / "000001_000000.png").rename(scene / "mask_visib" / "000001_000001.png")
    reader = DatasetReader(root)
    with caplog.at_level(logging.WARNING):
        first, second = reader.images("test")
    assert "labels of objects without a mesh are left out: [99]" in caplog.text
    assert [(item.gt_index, item.pixels_visible) for item in first.targets] == [(1, visible(1).sum()), (2, 0)]
    assert first.targets[1].visible_fraction == 0.0
    assert np.array_equal(reader.mask_visible(first, 1), visible(1))
    assert not reader.mask_visible(first, 2).any()
    assert second.targets == ()


def test_a_box_of_nothing_is_a_mask_of_nothing(tmp_path: Path) -> None:
    root = write_folder(tmp_path / "data", masks=False)
    gone = {"bbox_obj": [-1, -1, -1, -1], "bbox_visib": [-1, -1, -1, -1], "visib_fract": 0.0, "px_count_visib": 0}
    edit(root / "test" / "000003" / "scene_gt_info.json", lambda table: table | {"1": [gone]})
    reader = DatasetReader(root)
    image = reader.images("test")[0]
    assert not reader.mask(image, 0).any()
    assert image.targets[0].visible_fraction == 0.0


def test_a_list_of_targets_says_which_test_images_count(tmp_path: Path) -> None:
    root = write_folder(tmp_path / "data")
    rows = [{"scene_id": 3, "im_id": 2, "obj_id": 5, "inst_count": 1}]
    (root / "test_targets_bop19.json").write_text(json.dumps(rows))
    assert [image.image_id for image in DatasetReader(root).images("test")] == [2]
    (root / "test_targets_bop24.json").write_text(json.dumps([{"scene_id": 9, "im_id": 2}]))
    with pytest.raises(DatasetError, match=r"test_targets_bop24\.json: names none of the 2 test images"):
        DatasetReader(root).images("test")


def test_a_file_of_the_user_names_the_classes(tmp_path: Path) -> None:
    root = write_folder(tmp_path / "data")
    (root / "classes.json").write_text('{"5": "carton", "6": "vise"}')
    assert DatasetReader(root).objects[5].class_name == "carton"
    (root / "classes.json").write_text('{"5": "../carton"}')
    with pytest.raises(DatasetError, match=r"classes\.json: 5: class must be a word"):
        _ = DatasetReader(root).objects


def test_a_file_of_the_user_names_the_objects(tmp_path: Path) -> None:
    root = write_folder(tmp_path / "data")
    assert DatasetReader(root).objects[5].name == "obj_000005"
    (root / "names.json").write_text('{"5": "epal1"}')
    assert DatasetReader(root).objects[5].name == "epal1"


def test_a_cylinder_has_a_continuous_symmetry_off_the_origin(tmp_path: Path) -> None:
    root = write_folder(tmp_path / "data")

    def cylinder(table: dict) -> None:
        del table["5"]["symmetries_discrete"]
        table["5"]["symmetries_discrete"] = [[1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1]]
        table["5"]["symmetries_continuous"] = [{"axis": [0, 0, 2], "offset": [10, 0, 0]}]

    edit(root / "models" / "models_info.json", cylinder)
    group = DatasetReader(root).objects[5].symmetry.transforms
    assert len(group) == 630
    on_axis = group[:315] @ [0.01, 0.0, 0.3, 1.0]
    assert np.allclose(on_axis, [0.01, 0.0, 0.3, 1.0])


def as_members(root: Path, split: str, scene: int, packed: bool) -> dict[str, bytes]:
    """Return the imagewise files of a scene, made here with pycocotools."""
    folder, members = root / split / f"{scene:06d}", {}
    tables = {name: json.loads((folder / f"scene_{name}.json").read_text()) for name in ("camera", "gt", "gt_info")}
    for image in tables["camera"]:
        key = f"{scene:06d}_{int(image):06d}"
        members |= {f"{key}.{name}.json": json.dumps(table[image]).encode() for name, table in tables.items()}
        runs = coco_mask.encode(np.asfortranarray(visible(int(image)), np.uint8))
        text = {"size": [int(edge) for edge in runs["size"]], "counts": runs["counts"].decode()}
        if not packed:
            flat = visible(int(image)).T.ravel()
            ends = np.flatnonzero(np.diff(flat)) + 1
            text["counts"] = np.diff(np.concatenate([[0], ends, [flat.size]])).tolist()
        members[f"{key}.mask_visib.json"] = json.dumps({"0": text}).encode()
        members[f"{key}.gray.jpg"] = (folder / "gray" / f"{int(image):06d}.jpg").read_bytes()
        members[f"{key}.depth.png"] = (folder / "depth" / f"{int(image):06d}.png").read_bytes()
    return members


@pytest.mark.parametrize("packed", [True, False])
@pytest.mark.parametrize("kind", ["imagewise", "webdataset"])
def test_imagewise_folders_and_shards_of_others_are_read(tmp_path: Path, kind: str, packed: bool) -> None:
    plain = write_folder(tmp_path / "plain")
    root = tmp_path / "other"
    shutil.copytree(plain / "models", root / "models")
    for split, scene in (("train_pbr", 7), ("test", 3)):
        folder = root / f"{split}_web"
        folder.mkdir()
        members = as_members(plain, split, scene, packed)
        if kind == "imagewise":
            for name, data in members.items():
                (folder / name).write_bytes(data)
            continue
        with tarfile.open(folder / "shard-000000.tar", "w", format=tarfile.PAX_FORMAT) as archive:
            for name, data in sorted(members.items(), reverse=True):
                item = tarfile.TarInfo(f"./{name}")
                item.size, item.mtime, item.uname = len(data), 1.5e9, "someone"
                archive.addfile(item, io.BytesIO(data))
    a, b = DatasetReader(plain), DatasetReader(root)
    assert a.splits == b.splits
    for split in ("train", "val", "test"):
        for one, other in zip(a.images(split), b.images(split), strict=True):
            assert (one.scene_id, one.image_id, one.camera) == (other.scene_id, other.image_id, other.camera)
            assert np.array_equal(a.rgb(one), b.rgb(other))
            assert np.array_equal(a.depth(one), b.depth(other))
            assert np.array_equal(b.mask_visible(other, 0), visible(other.image_id))
            assert np.allclose(other.targets[0].T_camera_object[:3, 3], place(other.image_id) / 1000.0)
            assert other.targets[0].box_visible_xyxy == mask_box_xyxy(visible(other.image_id))
