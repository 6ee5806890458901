from dataclasses import replace

import pytest
import torch

from tests.estimators.pose.densefusion.networks.made_inputs import BATCH, CLASSES, made_gt, made_input, made_shapes
from warehouse_sim.estimators.pose.densefusion.losses import inlier_loss
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion
from warehouse_sim.estimators.pose.densefusion.settings import LossConfig
from warehouse_sim.estimators.registries import ESTIMATORS


def with_model(name: str) -> tuple[DenseFusion, object]:
    torch.manual_seed(0)
    config = replace(ESTIMATORS.get(name).network("nano"), inliers=True, upright=True)
    inputs = made_input(config)
    inside = (torch.rand(BATCH, config.points.count) < 0.7).float()
    return DenseFusion(config, CLASSES), inputs._replace(inside=inside, level=torch.tensor([1.0, 0.0]))


@pytest.mark.parametrize("name", ["densefusion-pointcloud", "densefusion-depth", "object-coordinates"])
def test_every_weight_is_trained(name: str) -> None:
    network, x = with_model(name)
    network.train()
    gt = made_gt()._replace(belongs=torch.rand(x.inside.shape) < 0.6)
    embedding = network.embed(x)
    proposal = network.propose(x, embedding)
    loss = network.loss(proposal, gt, made_shapes(), LossConfig())
    rotation, shift = network.refine(*proposal.hypotheses.most_confident(), x, embedding, proposal)
    (loss + rotation.sum() + shift.sum()).backward()
    missing = [key for key, value in network.named_parameters() if value.grad is None]
    assert missing == []
    assert network.inliers.output.weight.grad.abs().max() > 0


def test_points_that_are_not_trusted_count_for_nothing() -> None:
    network, x = with_model("densefusion-pointcloud")
    network.eval()
    first, second = network.points.layers(network._remarked(x), None)
    trust = (torch.arange(x.points.shape[1]) % 2 == 0).float().expand(BATCH, -1)
    half = [features[:, ::2] for features in second]
    torch.testing.assert_close(network.points.pool(second, trust), network.points.pool(half), atol=1e-5, rtol=1e-5)
    torch.testing.assert_close(network.points.pool(second, torch.ones_like(trust)), network.points.pool(second))
    assert len(first) == 1


def test_a_pose_counts_as_much_as_its_point() -> None:
    network, x = with_model("densefusion-pointcloud")
    found = network.eval()(x)
    expected = torch.sigmoid(found.inliers.pose_logit) * torch.sigmoid(found.inliers.logit)
    torch.testing.assert_close(torch.sigmoid(found.hypotheses.logit), expected)


def test_points_of_others_do_not_train_poses() -> None:
    network, x = with_model("densefusion-pointcloud")
    gt, shapes = made_gt(), made_shapes()
    belongs = torch.rand(x.inside.shape) < 0.5
    losses = []
    for shift in (0.0, 5.0):
        found = network.eval()(x)
        moved = found.hypotheses.translation + shift * (~belongs)[..., None]
        changed = found._replace(hypotheses=found.hypotheses._replace(translation=moved))
        losses.append(network.loss(changed, gt._replace(belongs=belongs), shapes, LossConfig()))
    torch.testing.assert_close(*losses)


def test_both_kinds_of_points_count_alike() -> None:
    belongs = torch.arange(100)[None] < 90
    logit = torch.where(belongs, 2.0, 3.0)
    # ln(1 + e^-2) of the object's points, ln(1 + e^3) of the others.
    assert float(inlier_loss(logit, belongs)) == pytest.approx((0.126928 + 3.048587) / 2, abs=1e-5)


def test_an_input_that_says_nothing_is_rejected() -> None:
    network, x = with_model("densefusion-pointcloud")
    with pytest.raises(ValueError, match="if it is in"):
        network(x._replace(inside=None))
    with pytest.raises(ValueError, match="gravity"):
        network(x._replace(level=None))
