"""A detector of sweeps is trained on the toy warehouse, finds what it saw all around, and gives poses."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import safetensors.numpy
import torch

from tests.estimators.pose.densefusion.made_run import made_run
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import ConfigError, InputError, TrainingError
from warehouse_sim.estimators.detectors.settings import DetectorConfig
from warehouse_sim.estimators.lidar import pointcloud
from warehouse_sim.estimators.lidar.direct import LidarDirect, SweepPoses
from warehouse_sim.estimators.lidar.projection import read_sweep
from warehouse_sim.estimators.lidar.sweep.estimator import TrainedSweepDetector
from warehouse_sim.estimators.lidar.sweep.range_image import id_boxes, range_image
from warehouse_sim.estimators.lidar.sweep.settings import (
    RangeImageConfig,
    SweepAugmentConfig,
    SweepDetectorConfig,
    WantedInSweepConfig,
)
from warehouse_sim.estimators.lidar.sweep.train import pixel_loss
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.pose.densefusion.estimator import Estimator
from warehouse_sim.estimators.predict import detect, predict
from warehouse_sim.estimators.registries import DETECTORS
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.estimators.train import train
from warehouse_sim.geometry.boxes import box_ious
from warehouse_sim.geometry.pose import make_transform, rotation_z, transform_points

CONFIG = SweepDetectorConfig(
    max_minutes=None,
    max_steps=150,
    batch=4,
    size="pico",
    validations=1,
    ema=0.9,
    learning_rate=4e-3,
    threads=1,
    workers=1,
    sweep=RangeImageConfig(256, 96, (-25.0, 7.0)),
    wanted=WantedInSweepConfig(points=8),
    augment=SweepAugmentConfig(window=128, mosaic=0, zoom=1.05, shift=1, noise=0.005, holes=0),
)


@pytest.fixture(scope="module")
def run(toy_root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return train("detector-sweep", toy_root, tmp_path_factory.mktemp("sweep") / "run", CONFIG, cache=Path("none"))


def gt_boxes(detector: TrainedSweepDetector, points: np.ndarray, ids: np.ndarray) -> np.ndarray:
    return id_boxes(range_image(points, detector.grid), ids, np.array([10, 11, 12]))


def test_it_finds_what_it_saw_wherever_the_lidar_is_turned(run: Path, toy_root: Path) -> None:
    detector, reader = TrainedSweepDetector(run), DatasetReader(toy_root)
    assert detector.classes == ("pallet",)
    requested, right, wrong, twice = 0, 0, 0, 0
    for image in reader.images("train"):
        scan = read_sweep(reader, image).reading
        for yaw in (0.0, np.pi, 1.0):
            points = transform_points(make_transform(rotation_z(yaw)), scan.points.astype(float))
            found, floor = detector.find(points)
            assert floor is not None
            gt = gt_boxes(detector, points, scan.instance_ids)
            boxes = np.array([item.box for item in found]).reshape(-1, 4)
            iou = np.max([box_ious(boxes, gt + np.array([turn, 0, turn, 0])) for turn in (-256, 0, 256)], axis=0)
            requested += len(gt)
            right += int((iou.max(axis=0, initial=0.0) > 0.5).sum())
            owners = [scan.instance_ids[item.own] for item in detector.around(points)]
            main = [int(np.bincount(ids).argmax()) for ids in owners]
            wrong += sum(number not in (10, 11, 12) for number in main)
            twice += len(main) - len(set(main))
            for item in found:
                assert 0 <= item.box[0] < 256
                assert item.class_name == "pallet"
    assert requested >= 18
    assert right >= 0.85 * requested
    # A point is one object's: boxes beside the better one of the same pallet leave nothing that is made of them.
    assert wrong <= 0.15 * requested
    assert twice == 0


def test_a_camera_is_told_of_what_it_sees(run: Path, toy_root: Path) -> None:
    reader = DatasetReader(toy_root)
    found, seconds = detect(str(run), toy_root, "train")
    assert len(seconds) == len(reader.images("train"))
    looking = {(image.scene_id, image.image_id) for image in reader.images("train") if image.targets}
    assert {(item.scene_id, item.image_id) for item in found} == looking
    for image in reader.images("train"):
        for target in image.targets:
            left, top, right, bottom = target.box_visible_xyxy
            mine = [item.edges for item in found if (item.scene_id, item.image_id) == (image.scene_id, image.image_id)]
            middle = [((a + c) / 2, (b + d) / 2) for a, b, c, d in mine]
            assert sum(left - 6 < u < right + 6 and top - 6 < v < bottom + 6 for u, v in middle) >= 1


@pytest.fixture
def network(run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the run folder of a network that ``lidar-direct`` takes for its own, behind the trained detector."""
    folder, place = made_run(tmp_path / "network"), "warehouse_sim.estimators.lidar.direct"
    monkeypatch.setattr(
        pointcloud, "load_estimator", lambda name, config: Estimator(folder, replace(config, device="cpu"))
    )
    monkeypatch.setattr(f"{place}.model_names", lambda: ["detector-sweep"])
    monkeypatch.setattr(f"{place}.model_dir", lambda name: run)
    return folder


def test_lidar_direct_from_a_sweep_to_poses(run: Path, toy_root: Path, network: Path) -> None:
    poses = predict("lidar-direct", toy_root, "train", PredictConfig())
    # A run folder stands where the bundled name can.
    same = predict("lidar-direct", toy_root, "train", PredictConfig(detections=str(run)))
    assert len(poses) == len(same) >= 2
    for one, other in zip(poses, same, strict=True):
        np.testing.assert_allclose(one.T_camera_object, other.T_camera_object, atol=1e-9)
    images = {(image.scene_id, image.image_id): image for image in DatasetReader(toy_root).images("train")}
    assert all(images[item.scene_id, item.image_id].targets for item in poses), "one camera looks away"
    direct = LidarDirect(SweepPoses(Estimator(network)), TrainedSweepDetector(run))
    reader = DatasetReader(toy_root)
    for image in reader.images("train"):
        around = direct.around(read_sweep(reader, image).reading.points)
        # Whether a camera looks there or not.
        assert len(around) >= 2
        assert all(1.0 < np.linalg.norm(item.T_camera_object[:3, 3]) < 9.0 for item in around)


@pytest.mark.real
@pytest.mark.usefixtures("network")
def test_recorded_sweeps_need_no_special_case(run: Path, real_data: Path) -> None:
    """KITTI's frames have no ids, no beams and no pallets: all is read, next to nothing is found."""
    poses = predict("lidar-direct", real_data / "kitti", "val", PredictConfig(detections=str(run)))
    assert all(np.isfinite(item.T_camera_object).all() for item in poses)
    reader = DatasetReader(real_data / "kitti")
    for image in reader.images("val"):
        mounted, down = read_sweep(reader, image), image.T_world_camera
        points = mounted.reading.points.astype(float)
        _, floor = TrainedSweepDetector(run).find(points)
        assert floor is not None
        # The plane that KITTI's file gives, in the camera frame, from another method.
        height = (down @ mounted.T_camera_sensor)[2, 3]
        assert floor[2] == pytest.approx(-height, abs=0.1)


def test_weights_of_depth_images_are_a_beginning(toy_root: Path, tmp_path: Path) -> None:
    depth = DetectorConfig(
        max_minutes=None, max_steps=1, batch=2, size="pico", input_wh=(160, 96), validations=1, threads=1
    )
    given = train("detector-depth", toy_root, tmp_path / "depth", depth, cache=Path("none"))
    config = replace(CONFIG, max_steps=1, learning_rate=1e-9, validations=1, ema=0.0)
    begun = train("detector-sweep", toy_root, tmp_path / "sweep", config, init=given, cache=Path("none"))
    a, b = (safetensors.numpy.load_file(folder / "weights.safetensors") for folder in (given, begun))
    first = "pyramid.start.0.0.weight"
    np.testing.assert_allclose(b[first][:, :4], a[first], atol=1e-6)
    np.testing.assert_allclose(b[first][:, 4:], 0.0, atol=1e-6)
    same = [name for name in b if name in a and name != first and a[name].shape == b[name].shape]
    weights = [name for name in same if name.endswith("weight")]
    assert len(weights) > 50
    for name in weights:
        np.testing.assert_allclose(a[name], b[name], atol=1e-6, err_msg=name)


def test_pixels_without_a_reading_teach_nothing() -> None:
    logits, shows = torch.zeros((1, 2, 2)), torch.tensor([[[1.0, 0.0], [torch.nan, 0.0]]])
    # log 2 each; the one that shows an object counts three times; three are known.
    assert float(pixel_loss(logits, shows)) == pytest.approx(np.log(2.0) * 5 / 3)
    other = logits.clone()
    other[0, 1, 0] = 9.0
    assert float(pixel_loss(other, shows)) == float(pixel_loss(logits, shows))
    assert float(pixel_loss(logits, torch.full((1, 2, 2), torch.nan))) == 0.0


def test_what_cannot_be_is_said(toy_root: Path, tmp_path: Path, run: Path) -> None:
    with pytest.raises(TrainingError, match="SweepDetectorConfig"):
        train("detector-sweep", toy_root, tmp_path / "a", DetectorConfig())
    config = replace(CONFIG, wanted=WantedInSweepConfig(points=100_000))
    with pytest.raises(TrainingError, match=r"--wanted.points"):
        train("detector-sweep", toy_root, tmp_path / "b", config, cache=Path("none"))
    wide = SweepAugmentConfig(window=256)
    with pytest.raises(ConfigError, match="half of 256"):
        replace(CONFIG, augment=wide)
    with pytest.raises(InputError, match="sweep-detector"):
        load_estimator(run)
    assert "detector-sweep" in DETECTORS.names()
