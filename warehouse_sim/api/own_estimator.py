"""A user's own estimator: an object, a class or a function becomes what the stages below take."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from warehouse_sim.errors import InputError, shown


class FunctionEstimator:
    """Estimates by a function that takes an ``RgbdImage`` and returns a list of ``PoseEstimate``."""

    objects: Sequence[Any] | None = None
    """It may know any object."""

    def __init__(self, function: Callable[[Any], Any]) -> None:
        self.estimate = function


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
