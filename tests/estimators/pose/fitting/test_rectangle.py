"""Quantiles of rows against numpy's."""

import numpy as np
import pytest

from warehouse_sim.estimators.pose.fitting.hypotheses import quantiles


@pytest.mark.parametrize("count", [1, 2, 3, 50, 401])
@pytest.mark.parametrize("fraction", [0.0, 0.02, 0.3, 0.5])
def test_quantiles_of_rows_are_those_of_numpy(count: int, fraction: float) -> None:
    values = np.random.default_rng(count).normal(size=(3, 2, count))
    np.testing.assert_allclose(
        quantiles(values, fraction), np.quantile(values, (fraction, 1.0 - fraction), axis=-1), atol=1e-12
    )
