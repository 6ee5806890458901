"""The fitted part of uncertainty, as plain numbers: sums of step functions of the features, one file a run folder.

A sum of steps is what gradient boosting with stumps fits (Friedman, Ann. Stat. 29, 2001), each feature's stumps put
together. Outside what it was fitted on it stays constant, so that a sensor never seen cannot drive it anywhere.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import yaml

from warehouse_sim.config import load_yaml, to_mapping
from warehouse_sim.errors import ConfigError, TrainingError
from warehouse_sim.estimators.pose.choose import Selection
from warehouse_sim.estimators.settings import Refinement
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.ranges import Fraction, Range, ranged

UNCERTAINTY = "uncertainty.yaml"
_LARGE = 1_000_000


@dataclass(frozen=True)
@ranged
class Steps:
    """A step function of one feature."""

    feature: str
    """Its name."""
    at: Annotated[tuple[float, ...], Range(-_LARGE, _LARGE)]
    """Where it steps, rising, -1,000,000 to 1,000,000."""
    value: Annotated[tuple[float, ...], Range(-_LARGE, _LARGE)]
    """Its values, one more than steps; the first holds up to and with the first step."""

    def __post_init__(self) -> None:
        if len(self.value) != len(self.at) + 1 or list(self.at) != sorted(self.at):
            raise ValueError(f"{self.feature}: value must have one number more than at, which must rise")

    def at_value(self, x: float) -> float:
        """Return the function's value."""
        return self.value[int(np.searchsorted(self.at, x, side="left"))]


@dataclass(frozen=True)
@ranged
class StepSum:
    """A constant and a step function of some features."""

    constant: Annotated[float, Range(-_LARGE, _LARGE)]
    """-1,000,000 to 1,000,000."""
    steps: tuple[Steps, ...] = ()
    """At most one a feature."""

    def value(self, features: Mapping[str, float]) -> float:
        """Return the sum at some features.

        Raises:
            TrainingError: A feature is not known.
        """
        lacking = [item.feature for item in self.steps if item.feature not in features]
        if lacking:
            raise TrainingError(f"{UNCERTAINTY}: no feature is called {lacking[0]!r}; fit it again with this version")
        return self.constant + sum(item.at_value(features[item.feature]) for item in self.steps)


@dataclass(frozen=True)
@ranged
class UncertaintyModel:
    """What features say of an estimate, for one way of selecting and refining."""

    selection: Selection
    """How one pose was chosen from the proposals."""
    refine: Refinement
    """What followed."""
    score: StepSum
    """Log odds that an estimate is right."""
    scale: StepSum
    """ln of the factor by which the RMS distance of the surface exceeds that of the readings' covariance, in one case
    of ten."""
    median: StepSum
    """The same, as likely as not."""
    range_edges: Annotated[tuple[float, ...], Range(0, _LARGE, "m")]
    """Distances (m) between the factors below, rising, 0-1,000,000."""
    range_factor: Annotated[tuple[float, ...], Range(0, _LARGE)]
    """Factors, one more than edges, that make the bound hold in nine of ten cases on scenes left out, 0-1,000,000."""
    samples: Annotated[int, Range(1, 1_000_000_000)]
    """Estimates that it was fitted on, 1-1,000,000,000."""
    auroc: Fraction
    """Of the score, on scenes left out, 0-1."""
    coverage: Fraction
    """Fraction of errors below the bound on scenes left out, 0-1; wanted is 0.9."""

    def __post_init__(self) -> None:
        if len(self.range_factor) != len(self.range_edges) + 1:
            raise ValueError("range_factor must have one number more than range_edges")

    def probability(self, features: Mapping[str, float]) -> float:
        """Return the probability (0-1) that an estimate is right."""
        return float(1.0 / (1.0 + np.exp(-np.clip(self.score.value(features), -30.0, 30.0))))

    def bound_factor(self, features: Mapping[str, float]) -> float:
        """Return what the readings' 90 % quantile is multiplied by."""
        factor = self.range_factor[int(np.searchsorted(self.range_edges, np.exp(features["log_range"]), side="left"))]
        return float(factor * np.exp(self.scale.value(features)))

    def median_factor(self, features: Mapping[str, float]) -> float:
        """Return what the readings' 90 % quantile is multiplied by for the error that is as likely exceeded as not."""
        return float(np.exp(self.median.value(features)))


@dataclass(frozen=True)
class Uncertainty:
    """The models of an estimator, one for each way of prediction that was fitted."""

    models: tuple[UncertaintyModel, ...] = ()
    """At most one for each pair of selection and refinement."""

    def get(self, selection: Selection, refine: Refinement) -> UncertaintyModel | None:
        """Return the model for a way of prediction; None when it was not fitted."""
        return next((item for item in self.models if (item.selection, item.refine) == (selection, refine)), None)

    def with_model(self, model: UncertaintyModel) -> "Uncertainty":
        """Return the models with one more, in place of that for the same way."""
        kept = [item for item in self.models if (item.selection, item.refine) != (model.selection, model.refine)]
        return Uncertainty((*kept, model))


def write_uncertainty(folder: Path, uncertainty: Uncertainty) -> None:
    """Write ``uncertainty.yaml`` of an estimator's folder."""
    make_folder(folder)
    text = yaml.safe_dump(to_mapping(uncertainty), sort_keys=False, default_flow_style=None, width=110)
    write_bytes(folder / UNCERTAINTY, text.encode(), durable=True)


def read_uncertainty(folder: Path) -> Uncertainty:
    """Return the models of an estimator's folder; none when nothing was fitted.

    Raises:
        TrainingError: The file is malformed.
    """
    if not (folder / UNCERTAINTY).is_file():
        return Uncertainty()
    try:
        return load_yaml(Uncertainty, folder / UNCERTAINTY)
    except ConfigError as problem:
        raise TrainingError(str(problem)) from problem
