import json
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.estimators.pose.densefusion.made_run import made_run
from warehouse_sim.cli.main import main
from warehouse_sim.errors import MissingPackageError, TrainingError
from warehouse_sim.estimators.detectors.settings import DetectorConfig
from warehouse_sim.estimators.detectors.yolov5.network import DetectorNetwork, DetectorNetworkConfig, DetectorRun
from warehouse_sim.estimators.export import Portable, PortableNetwork, export_network, export_run
from warehouse_sim.estimators.images.settings import ImageConfig
from warehouse_sim.estimators.lidar.sweep.network import SweepRun
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import PoseRun
from warehouse_sim.estimators.registries import trained_names
from warehouse_sim.estimators.segmenters.segnet.network import SegmenterNetwork, SegmenterNetworkConfig, SegmenterRun
from warehouse_sim.estimators.segmenters.segnet.settings import BoxCropConfig, SegmenterConfig
from warehouse_sim.learning.run_folder import write_weights
from warehouse_sim.resources import model_dir

pytest.importorskip("onnxscript")
onnx = pytest.importorskip("onnx")
onnxruntime = pytest.importorskip("onnxruntime")

SLOW = pytest.mark.slow


def disturb(network: torch.nn.Module) -> None:
    """Leave nothing at its initial value: statistics, biases and the refiner's zeros would hide an error."""
    torch.manual_seed(1)
    with torch.no_grad():
        for name, value in network.state_dict().items():
            if value.is_floating_point():
                noise = torch.rand_like(value) if name.endswith("running_var") else torch.randn_like(value)
                value.add_(0.02 * noise)


@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("densefusion-pointcloud", "nano"),
        *[pytest.param(name, "nano", marks=SLOW) for name in trained_names() if name != "densefusion-pointcloud"],
        pytest.param("densefusion-middle-2", "full", marks=SLOW),
    ],
)
def test_the_file_computes_what_torch_computes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, size: str
) -> None:
    run = made_run(tmp_path / "run", name, size=size)

    load = PoseRun.load_network

    def load_disturbed(config, folder):
        network = load(config, folder)
        disturb(network)
        return network

    monkeypatch.setattr(PoseRun, "load_network", load_disturbed)
    file = tmp_path / "folder" / "model.onnx"
    assert export_run(run, file) < PortableNetwork.tolerance
    session = onnxruntime.InferenceSession(file, providers=["CPUExecutionProvider"])
    config = PoseRun.read(run)
    network = PortableNetwork(config, config.load_network(run))
    known = {item.name for item in session.get_inputs()}
    assert tuple(item.name for item in session.get_outputs()) == network.outputs
    for batch in (1, 3):
        inputs = network.random_inputs(batch, seed=batch)
        with torch.no_grad():
            expected = network(**inputs)
        found = session.run(None, {key: value.numpy() for key, value in inputs.items() if key in known})
        for a, b in zip(found, expected, strict=True):
            np.testing.assert_allclose(a, b.numpy(), atol=PortableNetwork.tolerance)
    (item,) = json.loads(session.get_modelmeta().custom_metadata_map["objects"])
    assert (item["obj_id"], item["name"]) == (1, "toy-pallet")


class Deceiving(Portable):
    """A network that is another one while it is exported."""

    tolerance = 0.5
    outputs = ("y",)

    def forward(self, x: torch.Tensor) -> tuple[torch.Tensor]:
        return (2.0 * x if torch.compiler.is_compiling() else 2.0 * x + 1.0,)

    def random_inputs(self, batch: int, seed: int = 0) -> dict[str, torch.Tensor]:
        return {"x": torch.full((batch, 3), float(seed))}

    def metadata(self) -> dict[str, str]:
        return {}


def test_a_file_that_computes_something_else_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(TrainingError, match=r"differs from torch by 1\.0e\+00"):
        export_network(Deceiving(None, torch.nn.Identity()), tmp_path / "model.onnx")
    assert not (tmp_path / "model.onnx").exists()


def test_a_missing_package_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "onnxscript", None)
    with pytest.raises(MissingPackageError, match=r"warehouse-sim\[export\]"):
        export_run(made_run(tmp_path / "run"), tmp_path / "model.onnx")


@pytest.mark.slow
def test_a_network_of_surroundings_and_gravity_is_exported(tmp_path: Path) -> None:
    run = made_run(tmp_path / "run", preset="robust")
    assert export_run(run, tmp_path / "model.onnx") < PortableNetwork.tolerance
    session = onnxruntime.InferenceSession(tmp_path / "model.onnx", providers=["CPUExecutionProvider"])
    assert {"inside", "level"} <= {item.name for item in session.get_inputs()}


# Front ends as ONNX files, run by onnxruntime on inputs that the export did not see.


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
    rgb = torch.randint(0, 256, (5, 64, 128, 3), dtype=torch.uint8)
    depth, width = 3 + torch.rand(5, 64, 128), torch.full((5,), 0.3)
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
