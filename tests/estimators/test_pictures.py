from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from tests.estimators.pose.densefusion.made_run import made_run
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.predict import predict
from warehouse_sim.estimators.predict.pictures import write_pictures
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.schema import PoseEstimate


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
