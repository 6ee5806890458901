import pytest
import torch

from tests.estimators.pose.densefusion.networks.made_inputs import made_gt, made_shapes
from warehouse_sim.estimators.pose.densefusion.networks import heads
from warehouse_sim.estimators.pose.densefusion.networks.heads import HeadConfig, PoseHeads, SplitTrunk
from warehouse_sim.estimators.pose.densefusion.networks.interface import Hypotheses, Proposal
from warehouse_sim.estimators.pose.densefusion.settings import LossConfig


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
