import pytest
import torch

from tests.estimators.pose.densefusion.networks.made_inputs import made_input
from warehouse_sim.errors import ConfigError
from warehouse_sim.estimators.pose.densefusion.networks.image import (
    AttentionConfig,
    AttentionFusion,
    ImageBranch,
    ImageConfig,
    at_pixels,
)
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
