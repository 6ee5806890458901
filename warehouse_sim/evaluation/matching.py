"""Which estimate answers for which object: the rules of the BOP localisation task, by geometry alone."""

import numpy as np
from jaxtyping import Bool, Float, Int


def match(
    errors: Float[np.ndarray, "p g"], scores: Float[np.ndarray, " p"], counted: Bool[np.ndarray, " g"]
) -> Int[np.ndarray, " g"]:
    """Assign estimates of one object class in one image to its ground truths.

    An estimate nearest to a ground truth that does not count (one that is hardly visible) answers for that one and is
    set aside, as in the BOP 2024 detection task. Of the rest, as many as there are counted ground truths are kept, the
    highest scores first (BOP 2019 localisation); surplus guesses cannot help. The kept ones are matched greedily, the
    smallest error first, each used once.

    Args:
        errors: Error of each estimate against each ground truth; inf where they cannot belong together.
        scores: Confidence of each estimate.
        counted: Which ground truths enter the score.

    Returns:
        For each ground truth the row of its estimate, -1 where it has none.
    """
    matched = np.full(len(counted), -1)
    if errors.size == 0:
        return matched
    if errors.shape == (1, 1):  # most groups of large files
        return np.where(counted & np.isfinite(errors[0]), 0, -1)
    nearest = errors.argmin(axis=1)
    answers_for_uncounted = np.isfinite(errors.min(axis=1)) & ~counted[nearest]
    candidates = np.flatnonzero(~answers_for_uncounted)
    kept = candidates[np.argsort(-scores[candidates], kind="stable")][: int(counted.sum())]
    open_errors = np.full(errors.shape, np.inf)
    open_errors[np.ix_(kept, counted)] = errors[np.ix_(kept, counted)]
    for _ in range(len(kept)):
        row, column = np.unravel_index(open_errors.argmin(), open_errors.shape)
        if not np.isfinite(open_errors[row, column]):
            break
        matched[column] = row
        open_errors[row, :] = np.inf
        open_errors[:, column] = np.inf
    return matched
