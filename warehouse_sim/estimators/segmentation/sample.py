"""Training samples of a segmenter: stored crops seen through boxes that are off, as a detector's are."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, UInt8

from warehouse_sim.estimators.images.compose import Sample, disturbed
from warehouse_sim.estimators.images.settings import ImageAugmentConfig
from warehouse_sim.estimators.segmentation.face_points import MIRRORED
from warehouse_sim.estimators.segmentation.settings import BoxAugmentConfig, BoxCropConfig
from warehouse_sim.estimators.segmentation.window import Window
from warehouse_sim.learning.array_store import Arrays


@dataclass(frozen=True, eq=False)
class BoxSample:
    """One crop with its ground truth."""

    rgb: UInt8[np.ndarray, "h w 3"] | None
    depth: Float32[np.ndarray, "h w"] | None
    """Metres, 0 = no reading."""
    width_rad: float
    """Width of the crop over the focal length."""
    mask: Float32[np.ndarray, "h w"]
    points: Float32[np.ndarray, "p 3"]
    """Key points (px) with 1 where they are in the crop."""


def box_sample(
    arrays: Arrays, index: int, config: BoxCropConfig, augment: BoxAugmentConfig | None, rng: np.random.Generator
) -> BoxSample:
    """Return a stored crop as a network sees it.

    Args:
        arrays: Stored rows.
        index: Which of them.
        config: How boxes are cut out.
        augment: How crops are disturbed; None only moves the box, by a twentieth, as a good detector would.
        rng: Decides.
    """
    width, height = config.stored_wh
    fraction = 1.0 / (1.0 + 2.0 * config.stored_margin)
    size = np.array([width, height]) * fraction
    most = 0.05 if augment is None else augment.box
    low = (np.array([width, height]) - size) / 2 + rng.uniform(-most, most, 2) * size
    high = (np.array([width, height]) + size) / 2 + rng.uniform(-most, most, 2) * size
    window = Window.about((low[0], low[1], high[0], high[1]), config.margin, config.crop_wh)
    mirrored = augment is not None and bool(rng.random() < augment.flip)
    rgb = window.smooth(np.asarray(arrays["rgb"][index]), mirrored) if "rgb" in arrays else None
    depth = None
    if "depth" in arrays:
        depth = window.picked(np.asarray(arrays["depth"][index]), mirrored).astype(np.float32) / 1000.0
    if augment is not None:
        errors = ImageAugmentConfig(
            colour=augment.colour, depth_noise=augment.depth_noise, depth_holes=augment.depth_holes, depth_scale=0.02
        )
        noisy = disturbed(Sample(rgb, depth, np.zeros((0, 8), dtype=np.float32)), errors, rng)
        rgb, depth = noisy.rgb, noisy.depth
    mask = window.picked(np.asarray(arrays["mask"][index]), mirrored).astype(np.float32)
    points = np.array(arrays["points"][index])
    points[:, :2] = window.to_crop(points[:, :2].astype(float), mirrored)
    if mirrored:
        points = points[list(MIRRORED)]
    inside = ((points[:, :2] > -0.5) & (points[:, :2] < np.array(config.crop_wh) - 0.5)).all(axis=1)
    points[:, 2] *= inside
    stored_rad = float(arrays["facts"][index, 3]) / fraction / width
    return BoxSample(rgb, depth, stored_rad * (window.edges[2] - window.edges[0]), mask, points)
