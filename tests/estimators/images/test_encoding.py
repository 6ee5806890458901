import numpy as np
import torch

from warehouse_sim.estimators.images.encoding import CHANNELS, FARTHEST, channel_count, encode


def slow_relief(depth: np.ndarray, side: int, most: float) -> np.ndarray:
    half, out = side // 2, np.zeros_like(depth)
    for v, u in np.argwhere(depth > 0):
        window = depth[max(0, v - half) : v + half + 1, max(0, u - half) : u + half + 1]
        out[v, u] = np.clip((depth[v, u] - window[window > 0].mean()) / most, -1, 1)
    return out


def test_depth_channels_are_those_of_a_slow_count() -> None:
    rng = np.random.default_rng(0)
    depth = np.where(rng.random((40, 60)) < 0.8, rng.uniform(2.0, 2.6, (40, 60)), 0.0)
    depth[0, 0] = 60.0
    found = encode(("depth",), None, torch.from_numpy(depth)[None].float())[0].numpy()
    assert found.shape == (CHANNELS["depth"], 40, 60)
    clipped = np.minimum(depth, FARTHEST)
    np.testing.assert_allclose(found[0], clipped / 10, rtol=1e-6)
    np.testing.assert_array_equal(found[1], depth > 0)
    np.testing.assert_allclose(found[2], slow_relief(clipped, 5, 0.1), atol=2e-3)
    np.testing.assert_allclose(found[3], slow_relief(clipped, 25, 0.5), atol=2e-3)


def test_channels_follow_what_is_read() -> None:
    rgb = torch.randint(0, 256, (1, 8, 8, 3), dtype=torch.uint8)
    found = encode(("rgb", "depth"), rgb, torch.zeros(1, 8, 8))
    assert found.shape[1] == channel_count(("rgb", "depth")) == 7
    torch.testing.assert_close(found[0, :3].permute(1, 2, 0) * 255, rgb[0].float())
    assert (found[0, 3:] == 0).all()
