"""Distributions of intensity as IES files (ANSI/IES LM-63-2002, type C), relative to their greatest value."""

import numpy as np

from warehouse_sim.schema import IntensityDistribution
from warehouse_sim.schema.intensity import ANGLES, PLANES


def ies_text(distribution: IntensityDistribution) -> str:
    """Return the file of a distribution whose candela are fractions of the greatest.

    A light's luminance is multiplied by what the file says (openusd.org, "ShapingAPI", shaping:ies:file), so that 1 is
    the light's own. Nine digits keep single precision.
    """
    angles = " ".join(f"{angle:g}" for angle in np.linspace(0.0, 180.0, ANGLES))
    planes = " ".join(f"{plane:g}" for plane in np.arange(PLANES + 1) * (360.0 / PLANES))
    fraction = np.concatenate([distribution.fraction, distribution.fraction[:1]])
    rows = [_wrapped(" ".join(f"{value:.9g}" for value in row)) for row in fraction]
    head = ["IESNA:LM-63-2002", "[TEST] none: candela relative to the greatest", "[MANUFAC] none", "TILT=NONE"]
    numbers = f"1 -1 1 {ANGLES} {PLANES + 1} 1 2 0 0 0"
    return "\n".join([*head, numbers, "1 1 0", _wrapped(angles), _wrapped(planes), *rows]) + "\n"


def _wrapped(text: str) -> str:
    """Break lines after at most 132 characters, which LM-63 allows."""
    lines, line = list[str](), ""
    for word in text.split():
        if len(line) + len(word) > 130:
            lines.append(line)
            line = ""
        line = f"{line} {word}" if line else word
    return "\n".join([*lines, line])
