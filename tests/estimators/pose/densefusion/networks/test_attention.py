import pytest
import torch

from warehouse_sim.errors import ConfigError
from warehouse_sim.estimators.pose.densefusion.networks.image import AttentionConfig, AttentionFusion


@pytest.mark.parametrize("kind", ["self", "cross"])
def test_every_point_hears_every_other(kind: str) -> None:
    torch.manual_seed(0)
    fusion = AttentionFusion(AttentionConfig(16, heads=2, kind=kind), (6, 6)).eval()
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
    with pytest.raises(ValueError, match="joins two images, found 1"):
        AttentionFusion(AttentionConfig(kind="cross"), (32,))
