"""Poses from sweeps: frames that face objects, and answers that turn with the sweep."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.estimators.lidar.test_range_image import GRID
from tests.estimators.pose.densefusion.made_run import made_run
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import InputError, TrainingError
from warehouse_sim.estimators.image import RgbdImage, SweepView
from warehouse_sim.estimators.lidar.direct import SweepPoses
from warehouse_sim.estimators.lidar.projection import read_sweep
from warehouse_sim.estimators.lidar.sweep.estimator import SweepDetection, facing, own_points
from warehouse_sim.estimators.lidar.sweep.range_image import id_boxes, range_image
from warehouse_sim.estimators.lidar.sweep.rows import floor_in
from warehouse_sim.estimators.lidar.sweep.view import DOWN, facing_points, object_view
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.pose.densefusion.estimator import Estimator
from warehouse_sim.estimators.predict import predict
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import invert, make_transform, rotation_z, transform_points
from warehouse_sim.schema import PoseEstimate

UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def estimator(tmp_path_factory: pytest.TempPathFactory) -> Estimator:
    return Estimator(made_run(tmp_path_factory.mktemp("sweep") / "run"), PredictConfig(device="cpu"))


def sweep_of(toy_root: Path) -> tuple[np.ndarray, np.ndarray]:
    reader = DatasetReader(toy_root)
    scan = read_sweep(reader, reader.images("train")[0]).reading
    return scan.points.astype(float), scan.instance_ids


def image_of(points: np.ndarray, detections: list[SweepDetection], T_camera_lidar: np.ndarray) -> RgbdImage:
    camera = PinholeCamera.from_focal(1, 1, 1.0)
    return RgbdImage(camera, np.zeros((1, 1), np.float32), tuple(detections), sweep=SweepView(points, T_camera_lidar))


def detections_of(ids: np.ndarray) -> list[SweepDetection]:
    return [
        SweepDetection(None, "toy-pallet", 1.0, number, (0.0, 0.0, 1.0, 1.0), own=ids == number)
        for number in (10, 11, 12)
    ]


@pytest.mark.parametrize("yaw", [0.0, 1.0, np.pi - 1e-6, -np.pi + 1e-6, -2.2])
def test_what_faces_an_object_sees_the_same_wherever_it_stands(yaw: float) -> None:
    rng = np.random.default_rng(0)
    points = rng.uniform([3, -0.6, -0.8], [4, 0.6, -0.6], (200, 3))
    T = make_transform(rotation_z(yaw))
    view, turned = facing_points(points, UP), facing_points(transform_points(T, points), UP)
    np.testing.assert_allclose(turned, T @ view, atol=1e-9)
    np.testing.assert_allclose(turned[:3, :3].T @ turned[:3, :3], np.eye(3), atol=1e-12)
    seen = transform_points(invert(turned), transform_points(T, points))
    assert seen[:, 2].min() > 0
    assert abs(seen[:, 0].mean()) < 1e-9, "the middle is straight ahead"
    np.testing.assert_allclose(seen[:, 1].mean(), -points[:, 2].mean())
    np.testing.assert_allclose(turned[:3, :3] @ DOWN, -UP, atol=1e-12)


def test_the_view_holds_the_object_and_what_is_about_it(toy_root: Path) -> None:
    points, ids = sweep_of(toy_root)
    T = facing_points(points[ids == 10], UP)
    view = object_view(points, ids == 10, T, SweepDetection(None, 1, own=ids == 10, box_xyxy=(0, 0, 1, 1)))
    np.testing.assert_allclose(transform_points(T, view.own), points[ids == 10], atol=1e-9)
    v, u = np.nonzero(view.detections[0].mask)
    back = transform_points(T, view.camera.rays_at(u, v) * view.depth[v, u][:, None])
    away = np.linalg.norm(back[:, None] - points[ids == 10], axis=2).min(axis=1)
    assert np.median(away) < 0.1
    assert 0.0 < view.detections[0].mask.mean() < 0.5
    assert view.depth[~view.detections[0].mask].any()


def test_a_known_pose_comes_out_as_it_went_in(toy_root: Path, estimator: Estimator, monkeypatch) -> None:
    """Whatever the azimuth and the mounting: what the network says in its frame is put back to the camera's."""
    points, ids = sweep_of(toy_root)
    poses = SweepPoses(estimator)
    known = make_transform(rotation_z(0.3), np.array([3.0, 0.5, -0.7]))
    for yaw in (0.0, 2.0, np.pi):
        T = make_transform(rotation_z(yaw))
        T_camera_lidar = make_transform(rotation_z(0.7), np.array([0.1, -0.2, 0.3]))
        turned = transform_points(T, points)

        def answer(views, T_lidar_object=T @ known):
            (view,) = views
            np.testing.assert_allclose(view.gravity, DOWN)
            T_view_object = invert(view.T_lidar_view) @ T_lidar_object
            return [PoseEstimate(0, 0, 1, 0.5, T_view_object, 0.0, detection=view.detections[0].number)]

        monkeypatch.setattr(poses._chain, "estimate_all", answer)
        (found,) = poses.estimate(image_of(turned, detections_of(ids)[:1], T_camera_lidar))
        np.testing.assert_allclose(found.T_camera_object, T_camera_lidar @ T @ known, atol=1e-9)
        assert found.time > 0


def test_points_of_a_box_are_the_object_on_either_side_of_the_seam(toy_root: Path) -> None:
    points, ids = sweep_of(toy_root)
    for yaw in (0.0, np.pi):
        turned = transform_points(make_transform(rotation_z(yaw)), points)
        floor = floor_in(turned)
        assert floor is not None
        # The third pallet has 18 points.
        boxes = id_boxes(range_image(turned, GRID), ids, np.array([10, 11]))
        for number, box in zip((10, 11), boxes, strict=True):
            own = own_points(turned, GRID, box, facing(GRID, box, UP), floor)
            mine = ids == number
            assert (own & mine).sum() / (own | mine).sum() > 0.5
            # Where it is said which points show an object, these alone are looked at.
            told = own_points(turned, GRID, box, facing(GRID, box, UP), floor, mine)
            assert not (told & ~mine).any()
            assert told.sum() > 0.5 * mine.sum()


def test_given_detections_take_the_place_of_a_detector(
    toy_root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = made_run(tmp_path / "run")
    monkeypatch.setattr(
        "warehouse_sim.estimators.lidar.pointcloud.load_estimator",
        lambda name, config: Estimator(run, replace(config, device="cpu")),
    )
    for detections in ("gt", "gt-boxes"):
        found = predict("lidar-direct", toy_root, "train", PredictConfig(detections=detections))
        # The third pallet has too few points in the image, which cuts it.
        assert len(found) >= 2
        assert all(item.name == "toy-pallet" and 0 < item.time < 30 for item in found)


def test_what_is_missing_is_said_in_one_line(estimator: Estimator, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("warehouse_sim.estimators.lidar.direct.model_names", lambda: ["densefusion-pointcloud"])
    with pytest.raises(TrainingError, match="detector-sweep, which has no bundled weights") as problem:
        load_estimator("lidar-direct")
    assert "\n" not in str(problem.value)
    camera = PinholeCamera.from_focal(4, 4, 4.0)
    with pytest.raises(InputError, match="without a LiDAR's sweep"):
        SweepPoses(estimator).estimate(RgbdImage(camera, np.zeros((4, 4), np.float32), ()))
    with pytest.raises(InputError, match="--reject"):
        load_estimator("lidar-direct", PredictConfig(detections="gt", reject=0.1))
