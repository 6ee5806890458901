import cv2
import numpy as np

from warehouse_sim.sensors.rgbd.color import ColorConfig
from warehouse_sim.sensors.rgbd.color.camera import develop

RNG = np.random.default_rng(3)


def grain(sigma: float, code: float = 110.0) -> np.ndarray:
    return np.clip(code + sigma * RNG.standard_normal((240, 320, 3)), 0, 255).astype(np.uint8)


def test_grain_is_less_and_coarser_and_a_median_filter_does_not_remove_it() -> None:
    noisy = grain(4.0)
    developed = develop(noisy, noise=4.0, denoise=1.2, sharpen=0.5)
    assert developed[..., 1].std() < 0.8 * noisy[..., 1].std()

    def left(image: np.ndarray) -> float:
        return float(cv2.medianBlur(image, 3)[..., 1].std() / image[..., 1].std())

    assert left(developed) > left(noisy) + 0.15
    assert left(developed) > 0.6


def test_edges_are_amplified_by_their_fraction() -> None:
    edge = np.full((60, 80, 3), 80, np.uint8)
    edge[:, 40:] = 160
    base = cv2.GaussianBlur(edge[..., 0].astype(float), (5, 5), 0)
    expected = np.clip(base + 1.5 * (edge[..., 0] - base), 0, 255)
    sharp = develop(edge, noise=0.0, denoise=0.0, sharpen=0.5)
    assert np.abs(sharp[..., 0] - expected).max() <= 2.0
    assert sharp.max() > 165


def test_a_thin_line_has_no_colour_and_a_broad_one_keeps_it() -> None:
    for width, least, most in ((1, 0.0, 4.0), (12, 30.0, 100.0)):
        image = np.full((60, 80, 3), 120, np.uint8)
        image[:, 40 : 40 + width] = (160, 110, 70)
        developed = develop(image, noise=1.0, denoise=0.5, sharpen=0.0)[:, 40 + width // 2].astype(int)
        assert least <= np.abs(developed[:, 0] - developed[:, 2]).mean() <= most


def test_more_noise_is_removed_at_a_higher_gain_up_to_a_bound() -> None:
    config = ColorConfig()
    strengths = [config.denoise_at(gain) for gain in (1.0, 4.0, 16.0, 1e5, 1e6)]
    assert strengths[0] == config.denoise
    assert strengths[2] == 2.0 * config.denoise
    assert strengths == sorted(strengths)
    assert strengths[3] == strengths[4] == 3.2
    assert ColorConfig(denoise=5.0).denoise_at(1e6) == 5.0  # a setting is never taken back
    noisy = grain(9.0)
    weak, strong = (develop(noisy, noise=9.0, denoise=value, sharpen=0.8).std() for value in strengths[:3:2])
    assert strong < 0.9 * weak


def test_broad_blotches_of_noise_are_cored_and_an_edge_stays_sharp() -> None:
    coarse = np.kron(RNG.standard_normal((60, 80)), np.ones((4, 4)))[..., None]
    blotched = np.clip(np.rint(120 + 1.5 * coarse), 0, 255).astype(np.uint8).repeat(3, axis=2)
    assert develop(blotched, noise=6.0, denoise=1.0, sharpen=0.0)[..., 1].std() < 0.8 * blotched[..., 1].std()
    edge = np.full((60, 80, 3), 80, np.uint8)
    edge[:, 40:] = 160
    developed = develop(edge, noise=6.0, denoise=1.0, sharpen=0.0)
    assert np.abs(developed.astype(int) - edge).max() < 6  # which a soft threshold takes
