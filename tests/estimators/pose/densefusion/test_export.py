import json
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.estimators.pose.densefusion.made_run import made_run
from warehouse_sim.errors import MissingPackageError, TrainingError
from warehouse_sim.estimators.export import Portable, PortableNetwork, export_network, export_run
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import PoseRun
from warehouse_sim.estimators.registries import trained_names

pytest.importorskip("onnxscript")
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
