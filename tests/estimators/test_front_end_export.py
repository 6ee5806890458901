"""Front ends as ONNX files, run by onnxruntime on inputs that the export did not see."""

import json
from pathlib import Path

import numpy as np
import pytest
import torch

from warehouse_sim.cli.main import main
from warehouse_sim.estimators.detectors.yolov5.network import DetectorNetwork, DetectorNetworkConfig, DetectorRun
from warehouse_sim.estimators.detectors.yolov5.settings import DetectorConfig
from warehouse_sim.estimators.images.settings import ImageConfig
from warehouse_sim.estimators.lidar.sweep.network import SweepRun
from warehouse_sim.estimators.segmenters.segnet.network import SegmenterNetwork, SegmenterNetworkConfig, SegmenterRun
from warehouse_sim.estimators.segmenters.segnet.settings import BoxCropConfig, SegmenterConfig
from warehouse_sim.learning.run_folder import write_weights
from warehouse_sim.resources import model_dir

onnxruntime = pytest.importorskip("onnxruntime")
onnx = pytest.importorskip("onnx")


def session(path: Path):
    return onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"])


@pytest.mark.slow
def test_a_detector_gives_the_same_boxes(tmp_path: Path) -> None:
    torch.manual_seed(0)
    images, network = ImageConfig(("depth",), (128, 64)), DetectorNetworkConfig(width=0.05, classes=2)
    made = DetectorNetwork(network, images).eval()
    given = {"classes": ("a", "b"), "images": images, "network": network, "train": DetectorConfig()}
    DetectorRun(estimator="detector-depth", version="0", datasets=(), **given).write(tmp_path)
    write_weights(tmp_path, made)
    assert main(["export", str(tmp_path), "--out", str(tmp_path / "m.onnx")]) == 0
    props = {item.key: item.value for item in onnx.load(tmp_path / "m.onnx").metadata_props}
    width, height = json.loads(props["size_wh"])
    depth = torch.rand(4, height, width) * 9 * (torch.rand(4, height, width) < 0.9)
    boxes, scores = session(tmp_path / "m.onnx").run(None, {"depth": depth.numpy()})
    with torch.no_grad():
        expected = made.decode(made(None, depth))
    np.testing.assert_allclose(boxes, expected[0], atol=1e-2)
    np.testing.assert_allclose(scores, expected[1], atol=1e-4)


def test_a_segmenter_gives_the_same_masks(tmp_path: Path) -> None:
    torch.manual_seed(0)
    network = SegmenterNetworkConfig(("rgb", "depth"), 4, 6)
    made = SegmenterNetwork(network).eval()
    crop = BoxCropConfig(("rgb", "depth"))
    given = {"objects": (), "crop": crop, "network": network, "train": SegmenterConfig()}
    SegmenterRun(estimator="keypoints-rgbd", version="0", datasets=(), **given).write(tmp_path)
    write_weights(tmp_path, made)
    assert main(["export", str(tmp_path), "--out", str(tmp_path / "m.onnx")]) == 0
    rgb = torch.randint(0, 256, (5, 48, 96, 3), dtype=torch.uint8)
    depth, width = 3 + torch.rand(5, 48, 96), torch.full((5,), 0.3)
    inputs = {"rgb": rgb.numpy(), "depth": depth.numpy(), "width_rad": width.numpy()}
    mask, points = session(tmp_path / "m.onnx").run(None, inputs)
    with torch.no_grad():
        expected = made(rgb, depth, width)
    np.testing.assert_allclose(mask, torch.sigmoid(expected[0]), atol=1e-4)
    np.testing.assert_allclose(points, expected[1], atol=1e-3)


@pytest.mark.slow
def test_a_detector_of_sweeps_gives_the_same_boxes_and_pixels(tmp_path: Path) -> None:
    assert main(["export", "detector-sweep", "--out", str(tmp_path / "m.onnx")]) == 0
    props = {item.key: item.value for item in onnx.load(tmp_path / "m.onnx").metadata_props}
    width, height = json.loads(props["size_wh"])
    torch.manual_seed(1)
    seen, above = torch.rand(1, height, width) * 20 + 1, torch.rand(1, height, width) * 2
    seen[:, :, : width // 3] = 0.0
    above[:, : height // 4] = torch.nan
    boxes, scores, pixels = session(tmp_path / "m.onnx").run(None, {"range_m": seen.numpy(), "height_m": above.numpy()})
    run = model_dir("detector-sweep")
    network = SweepRun.read(run).load_network(run)
    with torch.no_grad():
        raw = network(None, torch.stack([seen, above], dim=1))
        expected = network.decode(raw)
    np.testing.assert_allclose(boxes, expected[0], atol=5e-2)
    np.testing.assert_allclose(scores, expected[1], atol=1e-4)
    np.testing.assert_allclose(pixels, torch.sigmoid(raw.pixels), atol=1e-4)
    assert np.isfinite(pixels).all()
