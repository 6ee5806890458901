"""Capture and read noise of an image sensor, in linear light."""

from functools import cache
from statistics import NormalDist

import cv2
import numpy as np
from jaxtyping import Float32


def add_noise(
    linear: Float32[np.ndarray, "*s"], rng: np.random.Generator, *, shot: float, read: float, gain: float
) -> Float32[np.ndarray, "*s"]:
    """Return ``linear`` with noise of variance ``gain shot x + gain^2 read``.

    EMVA 1288 release 4.0, section 2: shot noise is that of the electrons, of which a gain makes each brighter value out
    of fewer; read noise is amplified with them. In the form of Brooks et al. 2019, "Unprocessing images for learned raw
    denoising", ``x lambda_shot + lambda_read``, which finds 0.0001-0.012 for lambda_shot in photographs.

    Args:
        linear: Clean light (1 = saturation), >= 0.
        rng: Source of the noise.
        shot: Variance per linear value at gain 1.
        read: Variance at gain 1 that is always there.
        gain: Amplification over ISO 100, >= 1.
    """
    if shot == 0 and read == 0:
        return linear
    # Noise needs no finer draw than 256 equally likely Gaussian quantiles, which cost one byte each.
    draws = np.frombuffer(rng.bytes(linear.size), np.uint8).reshape(linear.shape)
    sigma = cv2.sqrt(linear * np.float32(gain * shot) + np.float32(gain * gain * read)).reshape(linear.shape)
    return linear + cv2.LUT(draws, _unit_quantiles()).reshape(linear.shape) * sigma


@cache
def _unit_quantiles() -> Float32[np.ndarray, " 256"]:
    values = np.array([NormalDist().inv_cdf((k + 0.5) / 256) for k in range(256)])
    return (values / values.std()).astype(np.float32)
