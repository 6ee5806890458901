"""Retroreflectors: light goes back to where it came from, and beside it the less, the larger the observation angle.

That angle lies at the surface, between the way to the lamp and the way to the lens. Bands of EN ISO 20471 return at
least 330 cd/(lx m^2) at 12 minutes of arc, where white plaster returns 1 / pi. That little is lost up to 20', then a
tenth is left at 1 deg, and the square of the angle from there on, is a prior of usual shape without a source; so is
the sixth power of the cosine of incidence.
"""

import numpy as np
from jaxtyping import Float32

from warehouse_sim.schema.things import RETROREFLECTIVE

_ANGLES_DEG = (0.2, 1.0 / 3.0, 1.0, 10.0)
_OVER_WHITE = tuple(np.pi * value for value in (330.0, 250.0, 25.0, 0.25))
_CENTRED_DEG = 0.01


def returned_by_retroreflectors(
    remission: Float32[np.ndarray, "h w"],
    cosine: Float32[np.ndarray, "h w"],
    depth: Float32[np.ndarray, "h w"],
    offset: float,
) -> Float32[np.ndarray, "h w"] | None:
    """Return the light that comes back from retroreflectors, white plaster facing the lamp at the same place = 1.

    Args:
        remission: Of the material at each pixel; 0 is returned where it is less than ``RETROREFLECTIVE``.
        cosine: Of the angle of incidence, 0-1.
        depth: Of the pixels (m).
        offset: From the lamp to the lens (m).

    Returns:
        None where no pixel shows a retroreflector, so that what follows can be left out.
    """
    back = (remission >= np.float32(RETROREFLECTIVE)) & (depth > 0)
    if not back.any():
        return None
    light = np.zeros_like(depth)
    angle = np.maximum(np.degrees(np.arctan2(offset, depth[back].astype(float))), _CENTRED_DEG)
    fractions = np.exp(np.interp(np.log(angle), np.log(_ANGLES_DEG), np.log(_OVER_WHITE)))
    light[back] = fractions * cosine[back].astype(float) ** 6
    return light
