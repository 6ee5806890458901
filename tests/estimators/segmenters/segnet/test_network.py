import numpy as np
import pytest
import torch
from torch.nn import functional

from warehouse_sim.errors import ConfigError
from warehouse_sim.estimators.segmenters.segnet.keypoints import find_peaks
from warehouse_sim.estimators.segmenters.segnet.network import SegNet, _unpooled, relative
from warehouse_sim.estimators.segmenters.segnet.settings import BoxCropConfig
from warehouse_sim.estimators.segmenters.segnet.task import keypoint_loss, mask_loss


def test_unpooling_is_that_of_torch() -> None:
    x = torch.randn(2, 5, 16, 32)
    pooled, place = functional.max_pool2d(x, 2, return_indices=True)
    assert torch.equal(_unpooled(pooled, place), functional.max_unpool2d(pooled, place, 2))


def test_maps_have_the_size_of_the_input() -> None:
    assert SegNet(4, 7, 8).eval()(torch.zeros(2, 4, 48, 96)).shape == (2, 7, 48, 96)
    with pytest.raises(ConfigError, match="multiples of 16"):
        BoxCropConfig(crop_wh=(90, 48))


def test_depth_is_relative_to_the_median_of_what_is_valid_in_the_middle() -> None:
    rng = np.random.default_rng(0)
    depth = np.where(rng.random((3, 48, 96)) < 0.6, rng.uniform(2, 4, (3, 48, 96)), 0.0).astype(np.float32)
    depth[2] = 0.0
    found = relative(torch.from_numpy(depth), torch.tensor([0.2, 0.3, 0.4])).numpy()
    for i in range(2):
        middle = depth[i, 12:36, 19:77]
        median = np.sort(middle[middle > 0])[(middle > 0).sum() // 2]
        offset = np.where(depth[i] > 0, depth[i] - median, 0.0)
        np.testing.assert_allclose(found[i, 0], np.clip(offset / 0.25, -1, 1), atol=1e-5)
        np.testing.assert_allclose(found[i, 1], np.clip(offset / 1.5, -1, 1), atol=1e-5)
        np.testing.assert_allclose(found[i, 3], np.log([0.2, 0.3][i] * median), atol=1e-5)
        np.testing.assert_array_equal(found[i, 2], depth[i] > 0)
    assert np.isfinite(found).all()
    assert (found[2, :3] == 0).all()


def test_the_right_mask_costs_nothing_and_the_opposite_much() -> None:
    gt = (torch.rand(3, 16, 32) < 0.4).float()
    assert mask_loss(40 * gt - 20, gt) < 1e-3
    assert mask_loss(20 - 40 * gt, gt) > 10


def test_descent_on_maps_puts_points_where_they_are() -> None:
    points = torch.tensor([[[10.3, 7.8, 1.0], [50.0, 20.0, 1.0], [5.0, 5.0, 0.0]]])
    maps = torch.nn.Parameter(torch.zeros(1, 3, 32, 64))
    optimiser = torch.optim.Adam([maps], lr=0.3)
    for _ in range(120):
        optimiser.zero_grad()
        keypoint_loss(maps, points).backward()
        optimiser.step()
    found = find_peaks(maps.detach())
    np.testing.assert_allclose(found.uv[0, :2], points[0, :2, :2], atol=0.15)
    assert (found.chance[0, :2] > 0.8).all()
    assert found.chance[0, 2] < 0.1
