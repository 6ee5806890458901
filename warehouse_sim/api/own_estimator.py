"""A user's own estimator: an object, a class or a function becomes what the stages below take."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from warehouse_sim.dataset.results.estimate_fault import require_estimates
from warehouse_sim.errors import InputError, shown
from warehouse_sim.schema import PoseEstimate


class FunctionEstimator:
    """Estimates by a function that takes an ``RgbdImage`` and returns a list of ``PoseEstimate``."""

    objects: Sequence[Any] | None = None
    """It may know any object."""

    def __init__(self, function: Callable[[Any], Any]) -> None:
        self._function = function
        self.__name__ = str(getattr(function, "__qualname__", type(function).__name__))

    def estimate(self, image: Any) -> list[PoseEstimate]:
        """Return what the function returns.

        Raises:
            InputError: It returns something else than a list of estimates.
        """
        return require_estimates(self._function(image), f"what {self.__name__} returns")


def opened_estimator(estimator: Any) -> Any:
    """Return a name or path as it is, and what estimates otherwise.

    Raises:
        InputError: It is none of these.
    """
    if isinstance(estimator, (str, Path)):
        return estimator
    if isinstance(estimator, type):
        estimator = estimator()
    estimate = getattr(estimator, "estimate", None)
    if callable(estimate):
        return estimator if hasattr(estimator, "objects") else FunctionEstimator(estimate)
    if callable(estimator):
        return FunctionEstimator(estimator)
    raise InputError(
        f"an estimator is a name, a run folder, an object with estimate(image) or a function, found {shown(estimator)}"
    )
