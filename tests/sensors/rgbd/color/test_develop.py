import cv2
import numpy as np

from warehouse_sim.sensors.rgbd.color.camera import develop

RNG = np.random.default_rng(3)


def grain(sigma: float, code: float = 110.0) -> np.ndarray:
    return np.clip(code + sigma * RNG.standard_normal((240, 320, 3)), 0, 255).astype(np.uint8)


def test_grain_is_less_and_coarser_and_a_median_filter_does_not_remove_it() -> None:
    noisy = grain(4.0)
    developed = develop(noisy, noise=4.0, denoise=1.0, sharpen=0.5)
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
