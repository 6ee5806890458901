from dataclasses import replace

import pytest
import torch

from tests.estimators.pose.densefusion.networks.made_inputs import (
    BATCH,
    build,
    made_gt,
    made_input,
    made_shapes,
)
from warehouse_sim.errors import ConfigError
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion
from warehouse_sim.estimators.pose.densefusion.networks.image import AttentionConfig, Upsample
from warehouse_sim.estimators.pose.densefusion.settings import LossConfig
from warehouse_sim.estimators.registries import ESTIMATORS, trained_names

READS = {
    "densefusion": [("rgb",)],
    "densefusion-early": [("rgb", "depth")],
    "densefusion-middle-1": [("rgb",), ("depth",)],
    "densefusion-middle-2": [("rgb",), ("depth",)],
    "densefusion-depth": [("depth",)],
    "densefusion-pointcloud": [],
    "object-coordinates": [("rgb",)],
}


def test_each_method_reads_what_its_name_says() -> None:
    assert trained_names() == sorted(READS)
    for name, reads in READS.items():
        method = ESTIMATORS.get(name)
        config = method.network("nano")
        assert method.name == name
        assert [image.reads for image in config.images] == reads
        assert config.reads_rgb == any("rgb" in read for read in reads) == ("RGB" in method.inputs)
        assert config.reads_depth == any("depth" in read for read in reads) == ("depth" in method.inputs)
        assert config.side_px == (48 if reads else None)


def _whole_loss(network: DenseFusion, x, config: LossConfig = LossConfig()) -> torch.Tensor:  # noqa: B008
    # The refiner's last layer starts at zero, which would stop its gradients at the first step.
    for output in network.refiner.outputs:
        torch.nn.init.normal_(output.weight, std=0.01)
    embedding = network.embed(x)
    proposal = network.propose(x, embedding)
    loss = network.loss(proposal, made_gt(), made_shapes(), config)
    rotation, shift = network.refine(*proposal.hypotheses.most_confident(), x, embedding)
    return loss + (rotation * 1.5 + 1).square().sum() + shift.square().sum()


@pytest.mark.parametrize(
    ("name", "size", "paper"),
    [
        *((name, "nano", paper) for name in sorted(READS) for paper in (False, True)),
        ("densefusion-middle-2", "small", False),
        ("object-coordinates", "small", False),
    ],
)
def test_the_loss_and_the_refiner_reach_every_parameter(name: str, size: str, paper: bool) -> None:
    network, x = build(name, size, paper)
    _whole_loss(network, x).backward()
    dead = [name for name, value in network.named_parameters() if value.grad is None or not value.grad.any()]
    assert dead == []
    assert all(bool(value.grad.isfinite().all()) for value in network.parameters())


@pytest.mark.parametrize("name", sorted(READS))
def test_mixed_precision_gives_about_the_same_loss_and_exact_types(name: str) -> None:
    losses = []
    for mixed in (False, True):
        network, x = build(name, "nano")
        with torch.autocast("cpu", torch.bfloat16, enabled=mixed):
            losses.append(_whole_loss(network, x))
            hypotheses = network(x).hypotheses
        assert {value.dtype for value in hypotheses} == {torch.float32}
        losses[-1].backward()
    assert losses[1].dtype == torch.float32
    assert float(losses[1].detach()) == pytest.approx(float(losses[0].detach()), rel=0.1)


@pytest.mark.parametrize("name", sorted(READS))
def test_each_object_is_answered_for_its_own_class(name: str) -> None:
    network, x = build(name, "nano")
    network.eval()
    # A class bias that was never trained is zero, which would hide a wrong row.
    torch.nn.init.normal_(network.refiner.trunks[0].from_class.weight)
    with torch.inference_mode():
        embedding = network.embed(x)
        mixed = network.propose(x, embedding).hypotheses
        for index, row in ((2, 0), (0, 1)):
            same = x._replace(class_index=torch.full((BATCH,), index))
            alone = network.propose(same, embedding).hypotheses
            for a, b in zip(mixed, alone, strict=True):
                torch.testing.assert_close(a[row], b[row])
                assert not torch.allclose(a[1 - row], b[1 - row])


def test_training_computes_outputs_of_a_share_of_the_points() -> None:
    network, x = build("densefusion-pointcloud", "nano")
    wanted = network.config.heads.training_points
    some = network(x).hypotheses
    every = network.eval()(x).hypotheses
    assert (some.logit.shape[1], every.logit.shape[1]) == (wanted, x.points.shape[1]) == (64, 256)
    for a, b in zip(some, every, strict=True):
        torch.testing.assert_close(a, b[:, :wanted], atol=1e-5, rtol=1e-4)


def test_points_may_come_in_any_order() -> None:
    for name in READS:
        network, x = build(name, "nano")
        network.eval()
        order = torch.randperm(x.points.shape[1])
        with torch.inference_mode():
            before = network(x).hypotheses
            after = network(x._replace(points=x.points[:, order], pixel=x.pixel[:, order])).hypotheses
        shuffled = before.translation if name == "object-coordinates" else before.translation[:, order]
        torch.testing.assert_close(after.translation, shuffled, atol=1e-4, rtol=1e-4)


@pytest.mark.parametrize("name", sorted(set(READS) - {"densefusion-pointcloud"}))
def test_every_image_that_is_read_matters(name: str) -> None:
    network, x = build(name, "nano")
    network.eval()
    with torch.inference_mode():
        before = network(x).hypotheses.translation
        for field in ("rgb", "depth"):
            image = getattr(x, field)
            if image is not None:
                other = network(x._replace(**{field: image.flip(1)})).hypotheses.translation
                assert not torch.allclose(before, other, atol=1e-6)


def test_a_missing_crop_is_named() -> None:
    network, x = build("densefusion-early", "nano")
    with pytest.raises(ValueError, match="reads depth crops"):
        network(x._replace(depth=None))


def weights_of(part: torch.nn.Module) -> int:
    return sum(value.numel() for value in part.parameters())


@pytest.mark.parametrize("objects", [1, 13, 21])
def test_paper_has_the_originals_parameters_to_the_last(objects: int) -> None:
    """Counted along the layers of ``lib/network.py``, ``pspnet.py`` and ``extractors.py``, less the dead classifier."""

    def layer(before: int, after: int, size: int = 1, bias: bool = True) -> int:
        return before * after * size**2 + after * bias

    widths = [(64, 64), (64, 64), (64, 128), (128, 128), (128, 256), (256, 256), (256, 512), (512, 512)]
    blocks = sum(layer(a, b, 3, False) + layer(b, b, 3, False) + (a != b) * a * b for a, b in widths)
    pyramid = 4 * layer(512, 512, bias=False) + layer(2560, 1024)
    decoder = layer(1024, 256, 3) + layer(256, 64, 3) + layer(64, 64, 3) + 3  # PReLU has one slope
    extractor = layer(3, 64, 7, False) + blocks + pyramid + decoder + layer(64, 32)
    points = layer(3, 64) + layer(64, 128) + layer(32, 64) + layer(64, 128)
    feature = points + layer(256, 512) + layer(512, 1024)
    head = 3 * (layer(1408, 640) + layer(640, 256) + layer(256, 128)) + layer(128, 8 * objects)
    refiner = points + layer(384, 512) + layer(512, 1024) + 2 * (layer(1024, 512) + layer(512, 128))
    network = DenseFusion(ESTIMATORS.get("densefusion").network("full", paper=True), objects)
    assert weights_of(network.images) == extractor
    assert weights_of(network.points) == feature
    assert weights_of(network.heads) == head
    assert weights_of(network.refiner) == refiner + layer(128, 7 * objects)
    # As rounded figures of the original go: 21.36, 21.37 and 21.38 M, and 1.92 to 1.94 M for the refiner.
    millions = round((extractor + feature + head) / 1e6, 2)
    assert millions == {1: 21.36, 13: 21.37, 21: 21.38}[objects]
    assert 1.915e6 < weights_of(network.refiner) < 1.945e6


def test_the_paper_decoder_aligns_corners() -> None:
    ours, theirs = (ESTIMATORS.get("densefusion").network("small", flag) for flag in (False, True))
    ramp = torch.linspace(0.0, 7.0, 8).expand(1, 1, 8, 8)
    for config in (ours, theirs):
        network = DenseFusion(config, 1)
        (up,) = [part for part in network.images[0].extractor.decoder if isinstance(part, Upsample)][:1]
        seen: list[torch.Tensor] = []
        up.conv = Recorder(seen)
        up(ramp)
        row = seen[0][0, 0, 0]
        assert (float(row[0]), float(row[-1])) == (0.0, 7.0)
        # Aligned, all steps are 7/15; else the first and the last pixels are half a pixel outside of the first centres.
        steps = row.diff()
        assert bool(torch.allclose(steps, torch.full((15,), 7 / 15), atol=1e-5)) == (config is theirs)


class Recorder(torch.nn.Module):
    def __init__(self, seen: list[torch.Tensor]) -> None:
        super().__init__()
        self.seen = seen

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        self.seen.append(x)
        return x


def test_paper_changes_what_it_says() -> None:
    ours, theirs = (DenseFusion(ESTIMATORS.get("densefusion").network("small", flag), 1) for flag in (False, True))
    kinds = [{type(module).__name__ for module in network.images.modules()} for network in (ours, theirs)]
    assert "BatchNorm2d" in kinds[0]
    assert "BatchNorm2d" not in kinds[1]
    assert (theirs.config.points.pooling, theirs.refiner.branch.pooling) == ("average", "average")
    assert (len(theirs.heads.trunks), len(theirs.refiner.trunks)) == (3, 2)
    assert theirs.config.heads.training_points is None
    assert theirs.heads.trunks[0].from_class is theirs.refiner.trunks[0].from_class is None
    x = made_input(theirs.config)._replace(class_index=torch.zeros(BATCH, dtype=torch.long))
    theirs.eval()
    with torch.inference_mode():
        # Log-softmax: the channels of each embedding are log-probabilities.
        torch.testing.assert_close(theirs.embed(x).exp().sum(dim=-1), torch.ones(x.pixel.shape))
        image = theirs.images[0].read_inputs(x)
        plain = ours.images[0].read_inputs(x)
    assert float(plain.abs().max()) <= 1.0
    torch.testing.assert_close(image[..., 0], (x.rgb[..., 0].float() - 0.485) / 0.229)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"fusion": AttentionConfig()}, "attention fuses images"),
        ({"images": "mixed"}, "crops of one size"),
    ],
)
def test_impossible_compositions_are_rejected(change: dict, message: str) -> None:
    config = ESTIMATORS.get("densefusion-pointcloud").network("nano")
    if change.get("images") == "mixed":
        image = ESTIMATORS.get("densefusion").network("nano").images[0]
        change = {"images": (image, replace(image, side_px=64))}
    with pytest.raises(ConfigError, match=message):
        replace(config, **change)
