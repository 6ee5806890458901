import json
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.toy import CAMERA, make_manifest, make_scene, observe
from warehouse_sim.dataset.formats.observation_files import image_amodal_mask
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import DatasetError


def test_everything_written_is_read_back(toy_root: Path) -> None:
    reader = DatasetReader(toy_root)
    compared = 0
    for split, scene_indices in make_manifest().splits.items():
        gt = [observation for index in scene_indices for observation in observe(make_scene(index))]
        for image, observation in zip(reader.images(split), gt, strict=True):
            assert (image.split, image.scene_id, image.image_id) == (
                split,
                observation.scene_index,
                observation.observation_index,
            )
            assert image.camera == CAMERA
            assert np.abs(image.T_world_camera - observation.T_world_camera).max() < 1e-12
            assert np.array_equal(reader.rgb(image), observation.rgbd.rgb)
            depth = reader.depth(image)
            assert depth.dtype == np.float32
            assert np.array_equal(depth == 0, observation.rgbd.depth == 0)
            assert np.abs(depth - observation.rgbd.depth).max() <= 0.5e-3 + 1e-6
            for target, annotation in zip(image.targets, observation.annotations, strict=True):
                assert (target.obj_id, target.instance_id) == (annotation.obj_id, annotation.instance_id)
                assert np.array_equal(target.T_camera_object[:3, :3], annotation.T_camera_object[:3, :3])
                assert np.abs(target.T_camera_object - annotation.T_camera_object).max() < 1e-12
                assert target.visible_fraction == annotation.visible_fraction
                assert target.pixels_visible == annotation.pixels_visible
                assert target.box_visible_xyxy == annotation.box_visible_xyxy
                assert target.box_amodal_xyxy == annotation.box_amodal_xyxy
                visible = observation.buffers.instance_mask == annotation.instance_id
                assert np.array_equal(reader.mask_visible(image, target.gt_index), visible)
                whole = image_amodal_mask(annotation, visible.shape)
                assert np.array_equal(reader.mask(image, target.gt_index), whole)
                compared += 1
    assert compared == 9


def test_unknown_split_lists_the_known_ones(toy_root: Path) -> None:
    with pytest.raises(DatasetError, match=r"no split 'eval' \(did you mean 'val'\?\); known: train, val, test"):
        DatasetReader(toy_root).images("eval")


def test_a_dataset_without_a_readable_format_is_rejected(toy_copy: Path) -> None:
    data = json.loads((toy_copy / "manifest.json").read_text())
    (toy_copy / "manifest.json").write_text(json.dumps(data | {"formats": ["ply"]}))
    with pytest.raises(
        DatasetError, match=r"training and scoring read; .* --formats: bop, bop_compact, bop_webdataset, linemod$"
    ):
        DatasetReader(toy_copy)


def change_entry(path: Path, key: str, change) -> None:
    data = json.loads(path.read_text())
    change(data[key])
    path.write_text(json.dumps(data))


@pytest.mark.parametrize(
    ("table", "change", "message"),
    [
        ("gt", lambda row: row[1].pop("obj_id"), "scene_gt.json: 0[1]: the entry 'obj_id' is missing"),
        ("gt", lambda row: row[1].update(cam_t_m2c=[1, 2]), "cam_t_m2c must be 3 numbers"),
        ("gt", lambda row: row.pop(), "scene_gt and scene_gt_info do not list the same number of objects"),
        ("gt_info", lambda row: row[0].update(bbox_visib=None), "bbox_visib must be of type list"),
        ("camera", lambda row: row.update(cam_K=[1, 0.5, 0, 0, 1, 0, 0, 0, 1]), "pinhole camera without skew"),
        (
            "gt",
            lambda row: row[1]["cam_t_m2c"].__setitem__(0, float("nan")),
            "is not valid JSON (NaN is no JSON number)",
        ),
    ],
)
def test_malformed_tables_are_named(toy_copy: Path, table: str, change, message: str) -> None:
    change_entry(toy_copy / "bop" / "train" / "000000" / f"scene_{table}.json", "0", change)
    with pytest.raises(DatasetError) as caught:
        DatasetReader(toy_copy).images("train")
    assert message in str(caught.value)
