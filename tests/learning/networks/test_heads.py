import torch

from warehouse_sim.learning.networks.heads import HeadConfig, PoseHeads, SplitTrunk


def test_split_trunk_equals_one_layer_on_the_tiled_features() -> None:
    torch.manual_seed(0)
    trunk = SplitTrunk(6, 5, (8, 4)).double()
    local, whole = torch.randn(2, 7, 6).double(), torch.randn(2, 5).double()
    tiled = torch.cat([local, whole[:, None].expand(2, 7, 5)], dim=2)
    weight = torch.cat([trunk.from_local.weight, trunk.from_global.weight], dim=1)
    first = torch.relu(torch.nn.functional.linear(tiled, weight, trunk.from_local.bias))
    torch.testing.assert_close(trunk(local, whole), trunk.rest(first))


def test_translation_is_an_offset_from_each_input_point() -> None:
    torch.manual_seed(0)
    heads = PoseHeads(HeadConfig((8, 4)), 6, 5, classes=1)
    local, whole, points = torch.randn(1, 3, 6), torch.randn(1, 5), torch.randn(1, 3, 3)
    index = torch.zeros(1, dtype=torch.long)
    shift = torch.tensor([1.0, -2.0, 3.0])
    a, b = (heads(local, whole, cloud, index).translation for cloud in (points, points + shift))
    torch.testing.assert_close(b - a, shift.expand(1, 3, 3))
