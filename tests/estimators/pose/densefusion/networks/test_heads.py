from dataclasses import replace

import pytest
import torch

from tests.estimators.pose.densefusion.networks.made_inputs import BATCH, CLASSES, made_gt, made_input, made_shapes
from warehouse_sim.estimators.pose.densefusion.losses import inlier_loss
from warehouse_sim.estimators.pose.densefusion.networks import heads
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion
from warehouse_sim.estimators.pose.densefusion.networks.heads import HeadConfig, PoseHeads, SplitTrunk
from warehouse_sim.estimators.pose.densefusion.networks.interface import Hypotheses, Proposal
from warehouse_sim.estimators.pose.densefusion.networks.points import rectified_average_and_max
from warehouse_sim.estimators.pose.densefusion.settings import LossConfig
from warehouse_sim.estimators.registries import ESTIMATORS


def test_split_trunk_equals_one_layer_on_the_tiled_features() -> None:
    torch.manual_seed(0)
    trunk = SplitTrunk(6, 5, (8, 4), classes=3).double()
    torch.nn.init.normal_(trunk.from_class.weight)
    local, whole, index = torch.randn(2, 7, 6).double(), torch.randn(2, 5).double(), torch.tensor([2, 1])
    one_hot = torch.nn.functional.one_hot(index, 3).double()
    tiled = torch.cat([local, torch.cat([whole, one_hot], dim=1)[:, None].expand(2, 7, 8)], dim=2)
    weight = torch.cat([trunk.from_local.weight, trunk.from_global.weight, trunk.from_class.weight.T], dim=1)
    first = torch.relu(torch.nn.functional.linear(tiled, weight, trunk.from_local.bias))
    torch.testing.assert_close(trunk(local, whole, index), trunk.rest(first))


def test_translation_is_an_offset_from_each_input_point() -> None:
    torch.manual_seed(0)
    index, shift = torch.zeros(1, dtype=torch.long), torch.tensor([1.0, -2.0, 3.0])
    local, whole, points = torch.randn(1, 3, 6), torch.randn(1, 5), torch.randn(1, 3, 3)
    for shared in (True, False):
        heads = PoseHeads(HeadConfig((8, 4), shared), 6, 5, classes=1)
        a, b = (heads(local, whole, cloud, index).hypotheses.translation for cloud in (points, points + shift))
        torch.testing.assert_close(b - a, shift.expand(1, 3, 3))


def test_start_rotation_is_proposed_for_its_class_only() -> None:
    torch.manual_seed(0)
    quat = torch.tensor([0.5, -0.5, 0.5, 0.5])
    for shared in (True, False):
        heads = PoseHeads(HeadConfig((8, 4), shared), 6, 5, classes=2)
        heads.start_rotation(1, quat)
        torch.nn.init.zeros_(heads.outputs[0].weight)
        found = heads(torch.randn(2, 3, 6), torch.randn(2, 5), torch.randn(2, 3, 3), torch.tensor([1, 0])).hypotheses
        torch.testing.assert_close(found.quat_wxyz[0], quat.expand(3, 4))
        assert not torch.allclose(found.quat_wxyz[1], quat.expand(3, 4))


def test_most_confident_is_each_objects_own() -> None:
    quat = torch.zeros(2, 3, 4)
    quat[..., 0] = 2.0
    translation = torch.arange(18.0).view(2, 3, 3)
    hypotheses = Hypotheses(quat, translation, torch.tensor([[0.0, 3.0, 1.0], [5.0, -1.0, 2.0]]))
    rotation, found = hypotheses.most_confident()
    torch.testing.assert_close(rotation, torch.eye(3).expand(2, 3, 3))
    assert torch.equal(found, torch.stack([translation[0, 1], translation[1, 0]]))


def test_nearest_point_loss_looks_at_its_share_of_the_hypotheses(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(heads, "_SURFACE_HYPOTHESES", 5)
    torch.manual_seed(0)
    found = Hypotheses(torch.randn(2, 8, 4), torch.randn(2, 8, 3), torch.randn(2, 8))
    changed = Hypotheses(*(torch.cat([value[:, :5], value[:, 5:] + 1.0], dim=1) for value in found))
    config = LossConfig(symmetry="nearest")
    gt, shapes = made_gt(), made_shapes()
    a, b = (PoseHeads.loss(Proposal(values), gt, shapes, config) for values in (found, changed))
    assert torch.equal(a, b)
    assert not torch.equal(a, PoseHeads.loss(Proposal(found), gt, shapes, LossConfig()))


@pytest.mark.parametrize("count", [64, 37])
def test_values_and_gradient_are_those_of_torch(count: int) -> None:
    torch.manual_seed(0)
    deep = torch.randn(3, count, 8, dtype=torch.double)
    deep[0, :, 0] = -1.0  # a channel that no point has
    wanted = torch.randn(3, 16, dtype=torch.double)
    values, gradients = [], []
    for ours in (True, False):
        x = deep.clone().requires_grad_()
        hidden = torch.relu(x)
        plain = torch.cat([hidden.mean(dim=1), hidden.amax(dim=1)], dim=-1)
        values.append(rectified_average_and_max(x) if ours else plain)
        (values[-1] * wanted).sum().backward()
        gradients.append(x.grad)
    torch.testing.assert_close(values[0], values[1])
    torch.testing.assert_close(gradients[0], gradients[1])
    with torch.inference_mode():
        torch.testing.assert_close(rectified_average_and_max(deep), values[1])


def test_input_is_left_as_it_is() -> None:
    deep = torch.randn(2, 16, 4, requires_grad=True)
    before = deep.detach().clone()
    rectified_average_and_max(deep)
    assert torch.equal(deep, before)


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
