import numpy as np

from warehouse_sim.evaluation.pairing import match

INF = np.inf


def matched(errors, scores, counted=None):
    errors = np.array(errors, dtype=float)
    counted = np.ones(errors.shape[1], bool) if counted is None else np.array(counted)
    return match(errors, np.array(scores, dtype=float), counted).tolist()


def test_each_estimate_goes_to_its_nearest_ground_truth():
    assert matched([[0.1, 2.0, 3.0], [3.0, 1.5, 0.2], [2.0, 0.3, 1.0]], [0.5, 0.6, 0.7]) == [0, 2, 1]


def test_the_smallest_error_goes_first_and_the_other_takes_what_is_left():
    assert matched([[0.3, 0.4], [0.1, 9.0]], [0.9, 0.1]) == [1, 0]


def test_a_missing_estimate_is_a_miss():
    assert matched([[0.1, 0.5]], [1.0]) == [0, -1]
    assert match(np.empty((0, 2)), np.empty(0), np.ones(2, bool)).tolist() == [-1, -1]


def test_surplus_guesses_with_low_scores_do_not_help():
    assert matched([[0.9], [0.0]], [0.8, 0.7]) == [0]
    assert matched([[0.9], [0.0]], [0.7, 0.8]) == [1]


def test_equal_scores_keep_the_order_of_the_file():
    assert matched([[0.9], [0.0]], [1.0, 1.0]) == [0]


def test_an_impossible_pair_is_never_matched():
    assert matched([[INF, INF], [INF, 0.3]], [1.0, 0.5]) == [-1, 1]


def test_an_estimate_of_a_hidden_object_is_set_aside_and_takes_no_place():
    errors = [[0.0, 1.0], [1.0, 0.05]]
    assert matched(errors, [0.9, 0.2], counted=[False, True]) == [-1, 1]


def test_an_image_where_nothing_counts_has_no_matches():
    assert matched([[0.1, 0.2]], [1.0], counted=[False, False]) == [-1, -1]


def slowly(errors, scores, counted):
    """The rules of the docstring by arrays that are searched again for each match."""
    nearest = errors.argmin(axis=1)
    aside = np.isfinite(errors.min(axis=1)) & ~counted[nearest]
    kept = [row for row in np.argsort(-scores, kind="stable") if not aside[row]][: counted.sum()]
    left = np.full(errors.shape, np.inf)
    left[np.ix_(kept, counted)] = errors[np.ix_(kept, counted)]
    matched = np.full(len(counted), -1)
    while np.isfinite(left).any():
        row, column = np.unravel_index(left.argmin(), left.shape)
        matched[column] = row
        left[row], left[:, column] = np.inf, np.inf
    return matched


def test_lists_match_as_a_search_for_the_smallest_error_does():
    rng = np.random.default_rng(6)
    for _ in range(500):
        shape = tuple(rng.integers(1, 6, 2))
        errors = rng.integers(0, 6, shape) / 10.0  # with ties
        errors[rng.random(shape) < 0.3] = np.inf
        scores, counted = rng.integers(0, 3, shape[0]) / 2.0, rng.random(shape[1]) < 0.7
        assert match(errors, scores, counted).tolist() == slowly(errors, scores, counted).tolist()
