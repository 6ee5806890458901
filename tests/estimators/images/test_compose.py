import cv2
import numpy as np
import pytest

from warehouse_sim.estimators.images import compose
from warehouse_sim.estimators.images.compose import ImageErrors, Sample, composed_sample, disturbed, plain_sample
from warehouse_sim.estimators.images.settings import ImageAugmentConfig
from warehouse_sim.geometry.boxes import mask_box_xyxy

CALM = ImageErrors(colour=0.0, depth_noise=0.0, depth_holes=0, depth_scale=0.0)
W, H = 320, 128
COLOURS = [0, 25, 60, 95, 140, 175, 210]
"""None like the grey beside images."""


def painted_images(count: int = 6) -> dict[str, np.ndarray]:
    """Return images that show one box each, in a colour and at a depth of its own."""
    rng = np.random.default_rng(0)
    labels = np.full((count, 4, 8), np.nan, dtype=np.float32)
    rgb, depth = np.zeros((count, H, W, 3), dtype=np.uint8), np.full((count, H, W), 20_000, dtype=np.uint16)
    for number in range(count):
        left, top = rng.integers(20, 150), rng.integers(20, 60)
        right, bottom = left + rng.integers(60, 120), top + rng.integers(20, 50)
        rgb[number, top:bottom, left:right] = COLOURS[number + 1]
        depth[number, top:bottom, left:right] = 1000 * (number + 1)
        labels[number, 0] = left, top, right, bottom, number + 1, 1.0, bottom - top, 0
    return {"rgb": rgb, "depth": depth, "labels": labels}


@pytest.mark.parametrize("mosaic", [0.0, 1.0])
def test_labels_stay_on_what_they_name(mosaic: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compose, "_ERRORS", CALM)
    monkeypatch.setattr(compose, "_MOSAIC", mosaic)
    arrays, config = painted_images(), ImageAugmentConfig()
    checked = 0
    for seed in range(40):
        sample = composed_sample(arrays, seed % 6, config, np.random.default_rng(seed))
        assert sample.rgb is not None
        assert sample.depth is not None
        shown = sample.labels[:, 4]
        for row in sample.labels:
            if (shown == row[4]).sum() > 1:  # A mosaic may show an image twice.
                continue
            mask = np.abs(sample.rgb[..., 0].astype(int) - COLOURS[int(row[4])]) < 8
            # Scaled images blend where they meet the grey beside them: lines a pixel or two wide have any colour.
            mask = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)) > 0
            left, top, right, bottom = mask_box_xyxy(mask)
            np.testing.assert_allclose([left, top, right + 1, bottom + 1], row[:4], atol=1.6)
            # Enlarged by the zoom, it is as much nearer: size times depth stays.
            height = arrays["labels"][int(row[4]) - 1, 0, 6]
            if row[5] == 1.0:
                middle = sample.depth[int((row[1] + row[3]) / 2), int((row[0] + row[2]) / 2)]
                assert middle * (row[3] - row[1]) == pytest.approx(row[4] * height, rel=0.02)
                assert row[6] == pytest.approx(row[3] - row[1], rel=0.02)
            checked += 1
    assert checked > 30


def test_what_is_cut_shows_less(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compose, "_ERRORS", CALM)
    monkeypatch.setattr(compose, "_SHIFT", 0.9)
    monkeypatch.setattr(compose, "_MOSAIC", 0.0)
    arrays, config = painted_images(), ImageAugmentConfig()
    fractions = []
    for seed in range(60):
        sample = composed_sample(arrays, 0, config, np.random.default_rng(seed))
        fractions += sample.labels[:, 5].tolist()
        assert (sample.labels[:, :4] >= 0).all()
        assert (sample.labels[:, 2] <= W).all()
        assert (sample.labels[:, 3] <= H).all()
    assert min(fractions) == 0.0
    assert any(0.15 < fraction < 0.9 for fraction in fractions)


def test_the_same_draws_give_the_same_sample() -> None:
    arrays = painted_images()
    a, b = (composed_sample(arrays, 2, ImageAugmentConfig(), np.random.default_rng(5)) for _ in range(2))
    np.testing.assert_array_equal(a.rgb, b.rgb)
    np.testing.assert_array_equal(a.depth, b.depth)
    np.testing.assert_array_equal(a.labels, b.labels)


def test_what_has_no_depth_gets_none() -> None:
    arrays = painted_images()
    arrays["depth"][:, 50:70] = 0
    sample = disturbed(plain_sample(arrays, 0), ImageErrors(depth_noise=0.05), np.random.default_rng(1))
    assert sample.depth is not None
    assert (sample.depth[50:70] == 0).all()
    assert (sample.depth >= 0).all()
    again = disturbed(plain_sample(arrays, 0), CALM, np.random.default_rng(1))
    np.testing.assert_array_equal(again.depth, plain_sample(arrays, 0).depth)


def test_noise_of_depth_grows_with_its_square_and_nothing_appears() -> None:
    depth = np.concatenate([np.full((300, 400), far, np.float32) for far in (0.0, 1.0, 4.0)])
    config = ImageErrors(colour=0.0, depth_noise=0.002, depth_holes=0, depth_scale=0.0)
    seen = disturbed(Sample(None, depth, np.zeros((0, 8), np.float32)), config, np.random.default_rng(2)).depth
    assert seen is not None
    empty, near, far = np.split(seen, 3)
    assert not empty.any()
    # Of 120,000 readings the deviation is known to 0.2 %, the mean to 0.6 % of it.
    for part, metres in ((near, 1.0), (far, 4.0)):
        assert np.isclose(part.std(), 0.002 * metres**2, rtol=0.02)
        assert abs(part.mean() - metres) < 0.002 * metres**2 / 50
