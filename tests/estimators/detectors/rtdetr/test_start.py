"""Weights of the library as a person has them: its folders and files."""

from dataclasses import replace
from pathlib import Path

import pytest
import safetensors.torch
import torch

from tests.estimators.detectors.rtdetr.conftest import IMAGES, SMALLEST
from warehouse_sim.errors import TrainingError, UnknownNameError
from warehouse_sim.estimators.detectors.rtdetr.network import RtdetrNetwork, make_detr
from warehouse_sim.estimators.detectors.rtdetr.train import start_from
from warehouse_sim.estimators.images.settings import ImageConfig

RGB = torch.randint(0, 256, (2, 64, 96, 3), dtype=torch.uint8, generator=torch.Generator().manual_seed(3))


def shaken(network: torch.nn.Module) -> torch.nn.Module:
    with torch.no_grad():
        for value in network.parameters():
            value += 0.02 * torch.randn(value.shape)
    return network.eval()


@pytest.fixture(scope="module")
def theirs(library) -> torch.nn.Module:
    torch.manual_seed(1)
    return shaken(make_detr(SMALLEST, 3))


@pytest.fixture(scope="module")
def folder(theirs, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("theirs")
    theirs.save_pretrained(place)
    return place


def assert_alike(network: RtdetrNetwork, theirs: torch.nn.Module) -> None:
    with torch.no_grad():
        expected = theirs(pixel_values=RGB.permute(0, 3, 1, 2) / 255.0)
        logits, boxes = network.eval()(RGB, None).layers[-1]
    torch.testing.assert_close(logits, expected.logits)
    torch.testing.assert_close(boxes, expected.pred_boxes)


@pytest.mark.parametrize("what", ["folder", "file"])
def test_what_the_library_saved_gives_what_the_library_gives(what: str, folder: Path, theirs) -> None:
    network = RtdetrNetwork(SMALLEST, IMAGES)
    path = folder if what == "folder" else folder / "model.safetensors"
    started, remark = start_from(path, network)
    own = sum(not name.endswith("num_batches_tracked") for name in network.state_dict())
    assert remark == f"{own} of {own} tensors from {folder / 'model.safetensors'}"
    assert started.name == str(path)
    assert_alike(network, theirs)


def test_files_of_the_first_version_are_taken_too(library, tmp_path: Path) -> None:
    own = make_detr(SMALLEST, 3).config
    known = library.RTDetrConfig().to_dict().keys() - {"backbone_config", "model_type", "architectures"}
    config = {name: value for name, value in own.to_dict().items() if name in known}
    first = shaken(
        library.RTDetrForObjectDetection(library.RTDetrConfig(backbone_config=own.backbone_config, **config))
    )
    first.save_pretrained(tmp_path)
    network = RtdetrNetwork(SMALLEST, IMAGES)
    start_from(tmp_path, network)
    assert_alike(network, first)


def test_weights_for_other_classes_and_inputs_stay_fresh_and_are_named(folder: Path) -> None:
    network = RtdetrNetwork(replace(SMALLEST, classes=1), ImageConfig(("rgb", "depth")))
    before = {name: value.clone() for name, value in network.state_dict().items()}
    _, remark = start_from(folder, network)
    assert "; fresh: model.backbone.model.embedder.embedder.0.convolution.weight, " in remark
    stayed = {name for name, value in network.state_dict().items() if value.equal(before[name])}
    assert {"model.enc_score_head.weight", "model.decoder.class_embed.0.weight"} <= stayed
    assert "model.enc_output.0.weight" not in stayed


def test_what_is_no_weights_is_rejected_in_one_line(folder: Path, tmp_path: Path) -> None:
    network = RtdetrNetwork(SMALLEST, IMAGES)
    (tmp_path / "model.pth").write_bytes(b"pickle")
    (tmp_path / "broken.safetensors").write_bytes(b"no such thing")
    safetensors.torch.save_file({"other": torch.zeros(3)}, tmp_path / "other.safetensors")
    with pytest.raises(TrainingError, match=r"model\.pth.*safetensors"):
        start_from(tmp_path / "model.pth", network)
    with pytest.raises(TrainingError, match=r"broken\.safetensors cannot be read"):
        start_from(tmp_path / "broken.safetensors", network)
    with pytest.raises(TrainingError, match=r"other\.safetensors fits 0 of \d+ tensors"):
        start_from(tmp_path / "other.safetensors", network)
    with pytest.raises(UnknownNameError):
        start_from("no-such-model", network)
