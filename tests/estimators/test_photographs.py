"""Photographs: what COCO's own tools read of the file, and what is said of photographs that are none."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from pycocotools.coco import COCO

from tests.estimators.pose.densefusion.made_run import made_run
from warehouse_sim.cli.main import main
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import InputError
from warehouse_sim.estimators.predict import predict
from warehouse_sim.estimators.predict.photographs import find_in_photographs
from warehouse_sim.estimators.predict.pictures import write_pictures
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.schema import PoseEstimate


@pytest.fixture(scope="module")
def photographs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder, rng = tmp_path_factory.mktemp("photographs"), np.random.default_rng(0)
    (folder / "below").mkdir()
    for name, shape in (("a.jpg", (240, 320)), ("below/b.PNG", (500, 300))):
        cv2.imwrite(str(folder / name), rng.integers(0, 255, (*shape, 3), dtype=np.uint8))
    (folder / "notes.txt").write_text("no photograph")
    return folder


def test_cocos_tools_read_every_photograph_and_what_was_found(photographs: Path, tmp_path: Path) -> None:
    out = tmp_path / "new" / "found.json"
    main(["detect", "detector-rgb", "--images", str(photographs), "--out", str(out), "--min-score", "0.0"])
    coco = COCO(str(out))
    sizes = {item["file_name"]: (item["width"], item["height"]) for item in coco.dataset["images"]}
    assert sizes == {"a.jpg": (320, 240), "below/b.PNG": (300, 500)}
    rows = coco.dataset["annotations"]
    assert rows
    assert {row["category_id"] for row in rows} <= set(coco.getCatIds())
    for row in rows:
        left, top, width, height = row["bbox"]
        image = coco.loadImgs(row["image_id"])[0]
        assert min(left, top) >= 0
        assert left + width <= image["width"] + 1e-6
        assert top + height <= image["height"] + 1e-6
        assert 0.0 <= row["score"] <= 1.0


def test_fewer_are_found_above_a_higher_score(photographs: Path) -> None:
    many, few = (find_in_photographs("detector-rgb", photographs, min_score=least) for least in (0.0, 0.01))
    assert len(few["annotations"]) < len(many["annotations"])
    assert all(row["score"] >= 0.0099 for row in few["annotations"])
    assert [item["file_name"] for item in few["images"]] == [item["file_name"] for item in many["images"]]


def test_what_is_no_photograph_is_named(photographs: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="detector-depth reads depth, which photographs lack"):
        find_in_photographs("detector-depth", photographs)
    with pytest.raises(InputError, match="holds no photograph"):
        find_in_photographs("detector-rgb", tmp_path)
    (tmp_path / "cut.jpg").write_bytes((photographs / "a.jpg").read_bytes()[:200])
    with pytest.raises(InputError, match=r"cut.jpg: is no image that can be read"):
        find_in_photographs("detector-rgb", tmp_path)
    assert json.dumps(find_in_photographs("detector-rgb", photographs))


def test_a_broken_photograph_is_named_before_any_is_looked_at(photographs: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(photographs, tmp_path / "photographs")
    (folder / "cut.jpg").write_bytes((photographs / "a.jpg").read_bytes()[:200])
    done = list[float]()
    with pytest.raises(InputError, match=r"cut.jpg: is no image that can be read, or is cut off; take it out"):
        find_in_photographs("detector-rgb", folder, lambda fraction, _: done.append(fraction))
    assert not done


def test_prediction_leaves_a_picture_of_each_image(toy_root: Path, tmp_path: Path) -> None:
    run, folder = made_run(tmp_path / "run", "densefusion-depth"), tmp_path / "pictures"
    predict(run, toy_root, "train", PredictConfig(), pictures=folder)
    names = {f"{image.scene_id:06d}_{image.image_id:06d}.png" for image in DatasetReader(toy_root).images("train")}
    assert {path.name for path in folder.iterdir()} == names


def test_boxes_are_drawn_where_the_camera_sees_their_corners(toy_root: Path, tmp_path: Path) -> None:
    reader = DatasetReader(toy_root)
    image = reader.images("train")[0]
    target = max(image.targets, key=lambda item: item.visible_fraction)
    pose = PoseEstimate(image.scene_id, image.image_id, target.obj_id, 0.9, target.T_camera_object)
    size = reader.objects[target.obj_id].size
    sampled = []
    for number, estimates in enumerate(([], [pose], [replace(pose, rejected=True)], [replace(pose, score=0.2)])):
        write_pictures(tmp_path / str(number), reader, [image], estimates, {target.obj_id: size})
        path = tmp_path / str(number) / f"{image.scene_id:06d}_{image.image_id:06d}.png"
        sampled.append(cv2.imread(str(path)).astype(int)[..., ::-1])
    empty, sure, rejected, unsure = sampled
    scale = empty.shape[1] / image.camera.width
    for u, v in image.camera.project(transform_points(target.T_camera_object, box_corners(size))):
        column, row = round((u + 0.5) * scale - 0.5), round((v + 0.5) * scale - 0.5)
        if 8 < column < empty.shape[1] - 8 and 30 < row < empty.shape[0] - 8:
            assert np.abs(sure[row - 1 : row + 2, column - 1 : column + 2] - [40, 230, 80]).sum(axis=2).min() < 60
    # The caption says that nothing is there.
    np.testing.assert_array_equal(rejected, empty)
    changed = (unsure != empty).any(axis=2)
    assert (unsure[changed][:, 0] > unsure[changed][:, 2]).mean() > 0.8
