"""Depth as a triangulating sensor measures it: noise that grows with distance, steps in disparity."""

import cv2
import numpy as np
from jaxtyping import Float32


def disturb_depth(
    depth: Float32[np.ndarray, "h w"],
    rng: np.random.Generator,
    *,
    sigma_base: float,
    sigma_quadratic: float,
    correlation_px: int,
    inverse_depth_step: float,
) -> Float32[np.ndarray, "h w"]:
    """Return ``depth`` (m, 0 = nothing) with Gaussian noise of ``sigma(z) = sigma_base + sigma_quadratic * z^2``.

    Triangulation gives ``z = f b / d``, so an error of the disparity ``d`` grows as ``dz = z^2 / (f b) dd``.

    Args:
        depth: True z-depth (m).
        rng: Source of the noise.
        sigma_base: Standard deviation at z = 0 (m).
        sigma_quadratic: Growth with the square of depth (1/m).
        correlation_px: Edge of the window that shares noise, as the matching window of a stereo camera does (px).
        inverse_depth_step: Step of 1 / z (1/m); 0 = none.
    """
    result = depth
    if sigma_base > 0 or sigma_quadratic > 0:
        sigma = np.float32(sigma_base) + np.float32(sigma_quadratic) * depth * depth
        result = depth + sigma * unit_noise((depth.shape[0], depth.shape[1]), rng, correlation_px)
    if inverse_depth_step > 0:
        inverse = np.divide(np.float32(1.0), result, out=np.zeros_like(result), where=result > 0)
        steps = np.rint(inverse / np.float32(inverse_depth_step)) * np.float32(inverse_depth_step)
        result = np.divide(np.float32(1.0), steps, out=np.zeros_like(result), where=steps > 0)
    return np.where(depth > 0, np.maximum(result, np.float32(0.0)), np.float32(0.0))


def unit_noise(size_hw: tuple[int, int], rng: np.random.Generator, correlation_px: int) -> Float32[np.ndarray, "h w"]:
    """Return Gaussian noise of variance 1 that is averaged over windows of ``correlation_px`` (odd, 1 = white)."""
    margin = correlation_px // 2
    height, width = size_hw[0] + 2 * margin, size_hw[1] + 2 * margin
    white = rng.standard_normal((height, width), dtype=np.float32)
    if margin == 0:
        return white
    # The mean of n^2 independent values has the standard deviation 1 / n.
    smooth = cv2.blur(white, (correlation_px, correlation_px)) * np.float32(correlation_px)
    return smooth[margin : height - margin, margin : width - margin]
