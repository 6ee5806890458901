"""The network as in the paper against the original's own code, weight by weight.

WAREHOUSE_SIM_DENSEFUSION names a checkout of github.com/j96w/DenseFusion (read at f7af2d9); without it the test is
skipped.
"""

import os
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.ecosystem.conftest import RunTool
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion
from warehouse_sim.estimators.pose.densefusion.networks.interface import NetworkInput
from warehouse_sim.estimators.registries import ESTIMATORS

pytestmark = pytest.mark.ecosystem
OBJECTS, COUNT = 3, 40
_STAGES = {0: "layer1.0", 1: "layer1.1", 2: "layer2.0", 3: "layer2.1", 4: "layer3.0", 5: "layer3.1", 6: "layer4.0",
           7: "layer4.1"}  # fmt: skip
_HEADS = "rtc"


@pytest.fixture
def checkout() -> Path:
    folder = Path(os.environ.get("WAREHOUSE_SIM_DENSEFUSION") or "/nowhere")
    if not (folder / "lib" / "network.py").is_file():
        pytest.skip("WAREHOUSE_SIM_DENSEFUSION names no checkout of github.com/j96w/DenseFusion")
    return folder


def extractor(state: dict[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    """Ours by the original's names."""
    found = {"feats.conv1.weight": state["stem.0.weight"]}
    for number, name in _STAGES.items():
        found[f"feats.{name}.conv1.weight"] = state[f"stages.{number}.main.0.weight"]
        found[f"feats.{name}.conv2.weight"] = state[f"stages.{number}.main.2.weight"]
        if f"stages.{number}.shortcut.weight" in state:
            found[f"feats.{name}.downsample.0.weight"] = state[f"stages.{number}.shortcut.weight"]
    for number in range(4):
        found[f"psp.stages.{number}.1.weight"] = state[f"pyramid.0.reduce.{number}.weight"]
    merge = state["pyramid.0.merge.0.weight"]
    # The original joins the averages first, then what they are of.
    found["psp.bottleneck.weight"] = torch.cat([merge[:, 512:], merge[:, :512]], dim=1)
    found["psp.bottleneck.bias"] = state["pyramid.0.merge.0.bias"]
    for number, place in enumerate((0, 2, 4), start=1):
        found[f"up_{number}.conv.1.weight"] = state[f"decoder.{place}.conv.0.weight"]
        found[f"up_{number}.conv.1.bias"] = state[f"decoder.{place}.conv.0.bias"]
        found[f"up_{number}.conv.2.weight"] = state[f"decoder.{place}.conv.1.weight"]
    found["final.0.weight"], found["final.0.bias"] = state["out.weight"], state["out.bias"]
    return {f"cnn.model.module.{name}": value for name, value in found.items()}


def features(state: dict[str, torch.Tensor], prefix: str) -> dict[str, torch.Tensor]:
    names = {"conv1": "geometry_1.0", "conv2": "geometry_2.0", "e_conv1": "image_1.0", "e_conv2": "image_2.0"}
    names |= {"conv5": "pooled.0", "conv6": "deepest"}
    return {
        f"feat.{theirs}.{kind}": state[f"{prefix}.{ours}.{kind}"]
        for theirs, ours in names.items()
        for kind in ("weight", "bias")
    }


def outputs(state: dict[str, torch.Tensor], prefix: str, name: str) -> dict[str, torch.Tensor]:
    """Object by object, then value by value."""
    weight, bias = state[f"{prefix}.weight"], state[f"{prefix}.bias"]
    return {f"{name}.weight": weight.transpose(1, 2).flatten(0, 1), f"{name}.bias": bias.flatten()}


def heads(state: dict[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    found = {}
    for number, letter in enumerate(_HEADS):
        trunk = f"heads.trunks.{number}"
        joined = torch.cat([state[f"{trunk}.from_local.weight"], state[f"{trunk}.from_global.weight"]], dim=1)
        found |= {f"conv1_{letter}.weight": joined, f"conv1_{letter}.bias": state[f"{trunk}.from_local.bias"]}
        for layer, place in ((2, 0), (3, 2)):
            for kind in ("weight", "bias"):
                found[f"conv{layer}_{letter}.{kind}"] = state[f"{trunk}.rest.{place}.{kind}"]
        found |= outputs(state, f"heads.outputs.{number}", f"conv4_{letter}")
    return found


def refiner(state: dict[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    found = features(state, "refiner.branch")
    for number, letter in enumerate(_HEADS[:2]):
        trunk = f"refiner.trunks.{number}"
        for kind in ("weight", "bias"):
            found[f"conv1_{letter}.{kind}"] = state[f"{trunk}.first.{kind}"]
            found[f"conv2_{letter}.{kind}"] = state[f"{trunk}.rest.0.{kind}"]
        found |= outputs(state, f"refiner.outputs.{number}", f"conv3_{letter}")
    return found


def test_the_paper_network_says_what_the_original_says(checkout: Path, tmp_path: Path, run_tool: RunTool) -> None:
    torch.manual_seed(0)
    network = DenseFusion(ESTIMATORS.get("densefusion").network("full", paper=True), OBJECTS).eval()
    for value in network.refiner.outputs.parameters():
        torch.nn.init.normal_(value, std=0.1)  # ours begins with zeros
    state = network.state_dict()
    branch = {name.removeprefix("images.0.extractor."): value for name, value in state.items() if "extractor" in name}
    estimator = extractor(branch) | features(state, "points") | heads(state)
    inputs = NetworkInput(
        torch.randn(1, COUNT, 3) * 0.2,
        torch.randint(0, 80 * 80, (1, COUNT)),
        torch.tensor([2]),
        torch.randint(0, 256, (1, 80, 80, 3), dtype=torch.uint8),
    )
    with torch.no_grad():
        embedding = network.embed(inputs)
        found = network.propose(inputs, embedding).hypotheses
        turn, shift = network.refiner(inputs.points, embedding, inputs.class_index)
    image = network.images[0].read_inputs(inputs).permute(0, 3, 1, 2)
    arrays = {
        **{f"estimator.{name}": value for name, value in estimator.items()},
        **{f"refiner.{name}": value for name, value in refiner(state).items()},
        "image": image.contiguous(),
        "points": inputs.points,
        "pixel": inputs.pixel,
        "number": inputs.class_index[None],
        "in_estimate": inputs.points,
        "objects": torch.tensor(OBJECTS),
    }
    np.savez(tmp_path / "in.npz", **{name: value.numpy() for name, value in arrays.items()})
    run_tool("densefusion_original.py", checkout, tmp_path / "in.npz", tmp_path / "out.npz")
    theirs = {name: torch.from_numpy(value) for name, value in np.load(tmp_path / "out.npz").items()}
    torch.testing.assert_close(embedding[0], theirs["embedding"][0].T, atol=2e-3, rtol=1e-3)
    torch.testing.assert_close(found.quat_wxyz, theirs["quat"], atol=1e-3, rtol=1e-3)
    torch.testing.assert_close(found.translation - inputs.points, theirs["offset"], atol=1e-3, rtol=1e-3)
    torch.testing.assert_close(torch.sigmoid(found.logit), theirs["confidence"][..., 0], atol=1e-3, rtol=1e-3)
    # Ours adds the correction to no turn.
    turned = turn - torch.tensor([1.0, 0.0, 0.0, 0.0])
    torch.testing.assert_close(turned, theirs["turn"], atol=1e-3, rtol=1e-3)
    torch.testing.assert_close(shift, theirs["shift"], atol=1e-3, rtol=1e-3)
    ours = [sum(value.numel() for value in part.parameters()) for part in (network.images, network.points, network)]
    ours = [*ours[:2], ours[2] - sum(value.numel() for value in network.refiner.parameters())]
    assert [*ours, sum(value.numel() for value in network.refiner.parameters())] == theirs["counts"].tolist()
