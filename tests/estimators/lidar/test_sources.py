"""Where depth and boxes come from, and ``detect-pointcloud`` from a sweep to poses."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.toy import make_dataset, make_manifest
from tests.estimators.pose.densefusion.made_run import made_run
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import DatasetError, InputError, UnknownNameError
from warehouse_sim.estimators.detections import Finder
from warehouse_sim.estimators.lidar.pointcloud import LidarChain, LidarMethod, resample
from warehouse_sim.estimators.lidar.projection import sparse_depth
from warehouse_sim.estimators.lidar.upsample import upsample
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.pose.densefusion.estimator import Estimator
from warehouse_sim.estimators.predict import predict
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.geometry.pose import transform_points


@pytest.fixture(scope="module")
def estimator(tmp_path_factory: pytest.TempPathFactory) -> Estimator:
    return Estimator(made_run(tmp_path_factory.mktemp("lidar") / "run"))


def test_depth_is_that_of_the_sweep(toy_root: Path, estimator: Estimator) -> None:
    reader = DatasetReader(toy_root)
    image = reader.images("train")[0]
    mounted = reader.sweep(image)
    assert mounted is not None
    points = transform_points(mounted.T_camera_sensor, mounted.reading.points.astype(float))
    sparse = sparse_depth(image.camera, points).depth
    found = {source: Finder(depth=source).find(estimator, reader, image) for source in ("lidar", "lidar-sparse", None)}
    assert all(found.values())
    np.testing.assert_array_equal(found["lidar"].depth, upsample(sparse))
    np.testing.assert_array_equal(found["lidar-sparse"].depth, sparse)
    np.testing.assert_array_equal(found[None].depth, reader.depth(image))
    # Depth of the floor changes by 10 cm from one row of this small image to the next.
    both = (sparse > 0) & (reader.depth(image) > 0)
    assert np.median(np.abs(sparse - reader.depth(image))[both]) < 0.05


def test_boxes_are_those_of_the_labels(toy_root: Path, estimator: Estimator) -> None:
    reader = DatasetReader(toy_root)
    image = reader.images("train")[0]
    masks, boxes = (Finder(name).find(estimator, reader, image) for name in ("gt", "gt-boxes"))
    assert masks is not None
    assert boxes is not None
    assert [item.number for item in masks.detections] == [item.number for item in boxes.detections]
    for item in boxes.detections:
        assert item.mask is None
        assert item.box_xyxy == image.targets[item.number].box_visible_xyxy
    clustered = Finder("gt-boxes+cluster")
    found = clustered.find(estimator, reader, image)
    assert found is not None
    assert all(item.mask is not None for item in found.detections)
    assert clustered.seconds > 0.0
    with pytest.raises(UnknownNameError, match="nobody"):
        Finder("gt-boxes+nobody")


def test_without_a_sweep_one_line_says_so(tmp_path: Path, estimator: Estimator) -> None:
    reader = DatasetReader(make_dataset(tmp_path / "data", replace(make_manifest(), formats=("bop",))))
    with pytest.raises(DatasetError, match=r"holds no sweep of image 0/0 for --depth lidar; generate it with a LiDAR"):
        Finder(depth="lidar").find(estimator, reader, reader.images("train")[0])


def test_the_network_reads_resampled_points_of_the_cluster(toy_root: Path, estimator: Estimator) -> None:
    reader = DatasetReader(toy_root)
    image = Finder("gt-boxes+cluster", depth="lidar").find(estimator, reader, reader.images("train")[0])
    assert image is not None
    crops = LidarChain(estimator).stages.select(image)
    assert len(crops) >= 2
    for crop, plain in zip(crops, estimator.cut(image), strict=True):
        assert crop.points.shape == (estimator.point_count, 3)
        assert (crop.position, crop.obj_id) == (plain.position, plain.obj_id)
        all_points = np.argwhere(image.detections[crop.position].mask & (image.depth > 0))
        low, high = plain.points.min(axis=0) - 0.3, plain.points.max(axis=0) + 0.3
        assert len(all_points) >= 32
        assert ((crop.points >= low) & (crop.points <= high)).all()
    np.testing.assert_array_equal(crops[0].points, LidarChain(estimator).stages.select(image)[0].points)


def test_sweeps_become_poses(toy_root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """``predict detect-pointcloud --detections gt-boxes``, with a network that knows the toy."""
    run, seen = made_run(tmp_path / "run"), []
    monkeypatch.setattr(
        "warehouse_sim.estimators.lidar.pointcloud.load_estimator",
        lambda name, config: Estimator(run, replace(config, device="cpu")),
    )
    monkeypatch.setattr(
        "warehouse_sim.estimators.lidar.pointcloud.resample",
        lambda points, *rest: (seen.append(len(points)), resample(points, *rest))[1],
    )
    for refine in ("none", "icp"):
        found = predict("detect-pointcloud", toy_root, "train", PredictConfig(detections="gt-boxes", refine=refine))
        assert len(found) >= 3
        assert len({(item.scene_id, item.image_id, item.detection) for item in found}) == len(found)
        assert all(item.name == "toy-pallet" and 0 < item.time < 10 for item in found)
    assert min(seen) >= 32


def test_a_sweep_alone_is_enough_once_a_detector_is_bundled(
    toy_root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run, requested = made_run(tmp_path / "run"), []
    place, boxes = "warehouse_sim.estimators.lidar.pointcloud", {}
    reader = DatasetReader(toy_root)
    for image in reader.images("train"):
        found = Finder("gt-boxes", depth="lidar").find(Estimator(run), reader, image)
        boxes[image.scene_id, image.image_id] = found.detections if found else ()

    def detect(image):
        requested.append(image.depth)
        return [replace(item, number=None) for item in boxes[image.scene_id, image.image_id]]

    monkeypatch.setattr(f"{place}.load_estimator", lambda name, config: Estimator(run, replace(config, device="cpu")))
    monkeypatch.setattr(f"{place}.model_names", lambda: ["detector-lidar"])
    monkeypatch.setattr(f"{place}.open_stages", lambda names: [{"detector-lidar": detect}[names]])
    poses = predict("detect-pointcloud", toy_root, "train", PredictConfig())
    assert len(poses) >= 3
    assert len(requested) == len(boxes)
    # What the detector sees is made of sweeps.
    sparse = Finder(depth="lidar").find(Estimator(run), reader, reader.images("train")[0])
    assert any(np.array_equal(depth, sparse.depth) for depth in requested)


def test_it_opens_with_bundled_weights_and_settings(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("warehouse_sim.estimators.lidar.pointcloud.model_names", lambda: [])
    found = load_estimator("detect-pointcloud", PredictConfig(selection="consensus", refine="icp"))
    assert isinstance(found, LidarChain)
    assert (found.depth_source, found.reads_rgb) == ("lidar", False)
    assert "epal1" in {item.name for item in found.objects}
    with pytest.raises(InputError, match="no uncertainty was fitted"):
        load_estimator("detect-pointcloud", PredictConfig(reject=0.5))
    with pytest.raises(InputError, match="densefusion reads an image"):
        LidarMethod("detector-lidar", "densefusion")()
