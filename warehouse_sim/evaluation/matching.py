"""Which estimate answers for which object: the rules of the BOP localisation task, by geometry alone."""

import math

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
    # Most groups are of a few: lists are quicker than arrays.
    rows, is_counted = errors.tolist(), counted.tolist()
    matched = [-1] * len(is_counted)
    candidates = []
    for number, row in enumerate(rows):
        least = min(row, default=math.inf)
        if least == math.inf or is_counted[row.index(least)]:
            candidates.append(number)
    worth = scores.tolist()
    candidates.sort(key=lambda number: -worth[number])
    kept = candidates[: sum(is_counted)]
    possible = sorted(
        (error, number, column)
        for number in kept
        for column, error in enumerate(rows[number])
        if is_counted[column] and error < math.inf
    )
    taken = set[int]()
    for _, number, column in possible:
        if number not in taken and matched[column] < 0:
            matched[column] = number
            taken.add(number)
    return np.array(matched, dtype=int)
