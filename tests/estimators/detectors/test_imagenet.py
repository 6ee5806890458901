"""Features that were trained on photographs: laid out as published, and left as they are."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import safetensors.torch
import torch
from torch import nn

from tests.estimators.detectors.test_training import CONFIG
from trainings import imagenet as conversion
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.detectors.yolov5.imagenet import WIDTHS, ImageNetFeatures
from warehouse_sim.estimators.predict import detect
from warehouse_sim.estimators.train import train

FROZEN = replace(CONFIG, backbone="efficientnet_lite0", max_steps=2, batch=2, validations=1)


def published(seed: int = 0) -> dict[str, torch.Tensor]:
    """Return random weights in the order and under names as those that are published have."""
    torch.manual_seed(seed)
    network = ImageNetFeatures()
    for module in network.modules():
        if isinstance(module, nn.BatchNorm2d):
            module.running_mean.uniform_(-0.1, 0.1)
            module.running_var.uniform_(0.5, 1.5)
    given = {f"_blocks.{number}": value for number, value in enumerate(network.state_dict().values())}
    return {**given, "_conv_head.weight": torch.ones(2), "_bn1.bias": torch.ones(2), "_fc.bias": torch.ones(2)}


@pytest.fixture(scope="module")
def start(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("imagenet")
    torch.save(published(), folder / "published.pth")
    conversion.main(folder / "start", folder / "published.pth")
    return folder / "start"


def test_layers_are_those_that_were_published() -> None:
    network = ImageNetFeatures()
    # EfficientNet-Lite0 has 4,652,008 parameters, of which its last convolution, normalisation and classes have these.
    classifier = 320 * 1280 + 2 * 1280 + 1280 * 1000 + 1000
    assert sum(parameter.numel() for parameter in network.parameters()) == 4_652_008 - classifier
    maps = network(torch.rand(2, 3, 64, 96))
    assert [tuple(one.shape) for one in maps] == [
        (2, width, 64 // stride, 96 // stride) for width, stride in zip(WIDTHS, (8, 16, 32), strict=True)
    ]


@pytest.mark.parametrize("kernel", [3, 5])
def test_halving_pads_as_tensorflow_does(kernel: int) -> None:
    block = next(
        item.within
        for item in ImageNetFeatures().modules()
        if hasattr(item, "within") and item.within[0].kernel_size[0] == kernel and item.within[0].stride[0] == 2
    )
    block[1].reset_running_stats()
    channels, side = block[0].in_channels, 8
    x = torch.rand(1, channels, side, side)
    weight = block[0].weight.detach().numpy()[:, 0]
    before = (kernel - 2) // 2  # of kernel - 2 that an even size needs, the smaller half
    padded = np.zeros((channels, side + kernel, side + kernel))
    padded[:, before : before + side, before : before + side] = x[0].numpy()
    expected = np.array(
        [
            [(padded[:, 2 * v : 2 * v + kernel, 2 * u : 2 * u + kernel] * weight).sum(axis=(1, 2)) for u in range(4)]
            for v in range(4)
        ]
    ).transpose(2, 0, 1) / np.sqrt(1.0 + 1e-3)
    np.testing.assert_allclose(block(x)[0].detach().numpy(), expected, atol=1e-5)


def test_training_leaves_features_and_their_statistics_alone(start: Path, toy_root: Path, tmp_path: Path) -> None:
    run = train("detector-rgb", toy_root, tmp_path / "run", FROZEN, init=str(start))
    given = safetensors.torch.load_file(start / "weights.safetensors")
    trained = safetensors.torch.load_file(run / "weights.safetensors")
    assert len(given) > 200
    for name, value in given.items():
        assert torch.equal(value, trained[name]), name
    assert any(not name.startswith("pyramid.features.") for name in trained)
    assert detect(str(run), toy_root, "test", min_score=0.001)[0]
    # Whoever goes on needs no ImageNet.
    again = train("detector-rgb", toy_root, tmp_path / "again", FROZEN, init=str(run))
    after = safetensors.torch.load_file(again / "weights.safetensors")
    assert all(torch.equal(value, after[name]) for name, value in given.items())
    assert not torch.equal(trained["heads.0.bias"], after["heads.0.bias"])


@pytest.mark.parametrize(
    ("name", "init", "words"),
    [
        ("detector-rgb", None, "is not trained; begin with weights that hold it: --init DIR"),
        ("detector-rgb", "detector-rgb-warehouses", "detector-rgb-warehouses has no weights of backbone"),
        ("detector-depth", "start", "reads colours alone; train detector-rgb"),
    ],
)
def test_what_cannot_be_trained_is_said_before_anything_is_read(
    name: str, init: str | None, words: str, start: Path, tmp_path: Path
) -> None:
    with pytest.raises(TrainingError, match=words):
        train(name, tmp_path, tmp_path / "run", FROZEN, init=str(start) if init == "start" else init)


def test_weights_of_another_network_are_rejected() -> None:
    given = published()
    first = next(iter(given))
    with pytest.raises(SystemExit, match="not those of EfficientNet-Lite0"):
        conversion.converted({**given, first: given[first][1:]})
