import pytest
import torch

from tests.estimators.pose.densefusion.networks.made_inputs import build, made_gt, made_input, made_shapes
from warehouse_sim.errors import ConfigError
from warehouse_sim.estimators.pose.densefusion.networks.heads import CoordinateHeads, HeadConfig
from warehouse_sim.estimators.pose.densefusion.networks.image import (
    AttentionConfig,
    AttentionFusion,
    ImageBranch,
    ImageConfig,
    at_pixels,
)
from warehouse_sim.estimators.pose.densefusion.networks.interface import Coordinates, GroundTruth, Hypotheses, Proposal
from warehouse_sim.estimators.pose.densefusion.networks.rotations import matrix_from_quat_wxyz
from warehouse_sim.estimators.pose.densefusion.settings import LossConfig
from warehouse_sim.estimators.registries import ESTIMATORS


def test_pixels_are_row_major() -> None:
    maps = torch.arange(2 * 3 * 4 * 2).view(2, 3, 4, 2).float()
    pixel = torch.tensor([[0, 5, 11], [4, 4, 1]])
    expected = torch.stack([maps[0].view(12, 2)[pixel[0]], maps[1].view(12, 2)[pixel[1]]])
    assert torch.equal(at_pixels(maps, pixel), expected)


@pytest.mark.parametrize("kind", ["unet", "psp-resnet18"])
def test_embedding_comes_from_the_points_own_pixel_and_its_surroundings(kind: str) -> None:
    torch.manual_seed(0)
    config = ImageConfig(kind=kind, side_px=48, width=8)
    branch = ImageBranch(config).eval()
    x = made_input(ESTIMATORS.get("densefusion").network("nano"))._replace(
        pixel=torch.tensor([[5 * 48 + 7, 40 * 48 + 40], [5 * 48 + 7, 40 * 48 + 40]])
    )
    with torch.inference_mode():
        before = branch(x)
        rgb = x.rgb.clone()
        rgb[:, 5, 7] = 255 - rgb[:, 5, 7]
        change = (branch(x._replace(rgb=rgb)) - before).abs().amax(dim=(0, 2))
    assert before.shape == (2, 2, 32)
    assert float(change[0]) > 10 * float(change[1])


@pytest.mark.parametrize("reads", [(), ("rgb", "rgb")])
def test_wrong_readings_are_rejected(reads: tuple) -> None:
    with pytest.raises(ConfigError, match="rgb, depth or both"):
        ImageConfig(reads=reads)


def test_wrong_side_is_rejected() -> None:
    with pytest.raises(ConfigError, match="multiple of 8"):
        ImageConfig(side_px=50)


def test_every_point_hears_every_other() -> None:
    torch.manual_seed(0)
    fusion = AttentionFusion(AttentionConfig(16, heads=2), (6, 6)).eval()
    colour, depth, points = torch.randn(2, 9, 6), torch.randn(2, 9, 6), torch.randn(2, 9, 3)
    with torch.inference_mode():
        before = fusion([colour, depth], points)
        other = depth.clone()
        other[0, 4] += 3.0
        changed = (fusion([colour, other], points) - before).abs().amax(dim=-1)
    assert before.shape == (2, 9, 16)
    assert bool((changed[0] > 1e-6).all())
    assert not changed[1].any()


def test_position_matters() -> None:
    torch.manual_seed(0)
    fusion = AttentionFusion(AttentionConfig(16, heads=2), (6, 6)).eval()
    same = torch.randn(1, 1, 6).expand(1, 5, 6)
    with torch.inference_mode():
        found = fusion([same, same], torch.randn(1, 5, 3))
    assert len(torch.unique(found[0], dim=0)) == 5


def test_impossible_sizes_are_rejected() -> None:
    with pytest.raises(ConfigError, match="multiple of heads"):
        AttentionConfig(30, heads=4)


def test_untrained_head_proposes_the_start_rotation() -> None:
    torch.manual_seed(0)
    heads = CoordinateHeads(HeadConfig((8, 4), predicts="coordinates"), 6, 5, classes=2)
    torch.nn.init.zeros_(heads.output.weight)
    quat = torch.tensor([0.5, -0.5, 0.5, 0.5])
    heads.start_rotation(1, quat)
    points = torch.randn(2, 30, 3)
    found = heads(torch.randn(2, 30, 6), torch.randn(2, 5), points, torch.tensor([1, 0])).hypotheses
    expected = torch.stack([matrix_from_quat_wxyz(quat), torch.eye(3)])
    torch.testing.assert_close(matrix_from_quat_wxyz(found.quat_wxyz[:, 0]), expected, atol=1e-5, rtol=0)
    assert "start" in heads.state_dict()


def test_true_coordinates_beat_all_others() -> None:
    torch.manual_seed(0)
    gt, shapes, points = made_gt(), made_shapes(), torch.randn(2, 30, 3)
    object_points = (points - gt.translation[:, None]) @ gt.rotation

    def loss(moved: torch.Tensor) -> float:
        quat = torch.randn(2, 1, 4, generator=torch.Generator().manual_seed(1))
        hypotheses = Hypotheses(quat, torch.zeros(2, 1, 3), torch.zeros(2, 1))
        coordinates = Coordinates(points, moved, torch.full((2, 30), -2.0))
        return float(CoordinateHeads.loss(Proposal(hypotheses, coordinates), gt, shapes, LossConfig()))

    assert loss(object_points) < min(loss(object_points + 0.01 * torch.randn(2, 30, 3)) for _ in range(5))


def test_fitted_pose_is_trained_whatever_its_confidence() -> None:
    network, x = build("object-coordinates", "nano")
    gradients = []
    for logit in (-30.0, 0.0):
        network.zero_grad()
        found, coordinates, _ = network(x)
        with_uncertainty = Proposal(found._replace(logit=torch.full_like(found.logit, logit)), coordinates)
        torch.manual_seed(1)
        gt = GroundTruth(matrix_from_quat_wxyz(torch.randn(2, 4)), torch.zeros(2, 3), x.class_index)
        network.loss(with_uncertainty, gt, made_shapes(), LossConfig()).backward()
        gradients.append(network.heads.output.weight.grad.clone())
        torch.manual_seed(0)
    assert bool(gradients[0].any())
    torch.testing.assert_close(*gradients)
