"""Which points of a detection are its object's, as far as whoever proposed the poses can tell."""

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.estimators.chain import Proposals

LEAST_POINTS = 32
"""Of fewer points nothing is estimated; with fewer that are trusted, all are taken."""


def own_of(proposals: Proposals, row: int, points: Float[np.ndarray, "p 3"]) -> Bool[np.ndarray, " p"]:
    """Return which points (camera frame, m) of object ``row`` to look at.

    Masks may hold other things, boxes always do. Proposals that tell say so by ``trusted``, see ``NetworkProposals``.
    """
    trusted = getattr(proposals, "trusted", None)
    own: Bool[np.ndarray, " p"] = np.ones(len(points), dtype=bool) if trusted is None else trusted(row, points)
    return own if own.sum() >= LEAST_POINTS else np.ones(len(points), dtype=bool)
