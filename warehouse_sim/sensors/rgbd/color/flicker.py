"""Light that pulses with the mains while rows are exposed one after the other."""

import numpy as np
from jaxtyping import Float32


def flicker_factor(
    rows: int, *, depth: float, frequency: float, shutter: float, readout: float, phase: float
) -> Float32[np.ndarray, "h 1 1"]:
    """Return the light of each row relative to its mean: that of ``1 + depth cos(2 pi f t)`` over the exposure.

    The mean over an exposure T of a cosine is the cosine at its middle times sin(pi f T) / (pi f T): times of whole
    periods see nothing. A depth of 0.08 at 100 Hz is where IEEE Std 1789-2015 ends low risk (0.08 % per hertz).

    Args:
        rows: Of the image.
        depth: Of the modulation, 0-1.
        frequency: Of the light (Hz).
        shutter: For how long each row is exposed (s).
        readout: From the first row's exposure to the last one's (s); 0 = all at once.
        phase: Of the light at the middle of the exposure of the middle row, in periods.
    """
    time = ((np.arange(rows) + 0.5) / rows - 0.5) * readout
    seen = depth * np.sinc(frequency * shutter) * np.cos(2.0 * np.pi * (frequency * time + phase))
    return (1.0 + seen).astype(np.float32)[:, None, None]
