"""How a network's confidence predicts the error of its pose: curves fitted on validation data, as a file."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import yaml

from warehouse_sim.config import load_yaml, to_mapping
from warehouse_sim.errors import ConfigError, TrainingError
from warehouse_sim.estimators.pose.choose import Selection
from warehouse_sim.estimators.settings import Refinement
from warehouse_sim.output import write_bytes
from warehouse_sim.ranges import Fraction, Range, ranged

CALIBRATION = "calibration.yaml"


@dataclass(frozen=True)
@ranged
class ErrorCurve:
    """Error against confidence for one way of selecting and refining; errors in diameters of the object.

    An error is the RMS distance of the object's surface under the estimated pose from that under the nearest pose that
    looks like the true one.
    """

    selection: Selection
    """How one pose was chosen from the proposals."""
    refine: Refinement
    """What followed the network."""
    confidence: Annotated[tuple[float, ...], Range(0, 1)]
    """Knots, rising, 0-1."""
    error: Annotated[tuple[float, ...], Range(0, 1000, "diameters")]
    """Median error at each knot (diameters), never rising, 0-1,000."""
    bound_factor: Annotated[float, Range(1, 1_000_000)]
    """The error stays below this multiple of its median in nine cases of ten, 1-1,000,000."""
    samples: Annotated[int, Range(1, 1_000_000_000)]
    """Objects that it was fitted on, 1-1,000,000,000."""
    spearman: Annotated[float, Range(-1, 1)]
    """Rank correlation of predicted and true error on scenes left out of the fit, -1 to 1."""
    coverage: Fraction
    """Fraction of true errors below the bound on scenes left out of the fit, 0-1; wanted is 0.9."""

    def error_at(self, confidence: float) -> float:
        """Return the error (diameters) that is as likely exceeded as not."""
        return float(np.interp(confidence, self.confidence, self.error))

    def bound_at(self, confidence: float) -> float:
        """Return the error (diameters) that is exceeded in one case of ten."""
        return self.bound_factor * self.error_at(confidence)


@dataclass(frozen=True)
@ranged
class Calibration:
    """The curves of a run, one for each way of prediction that was calibrated."""

    curves: tuple[ErrorCurve, ...] = ()
    """At most one for each pair of selection and refinement."""
    refiner_iterations: Annotated[int, Range(0, 100)] | None = None
    """Corrections by the network's own refiner that help on val, with which the curves were fitted, 0-100; none where
    that was not asked."""

    def get(self, selection: Selection, refine: Refinement) -> ErrorCurve | None:
        """Return the curve for a way of prediction; None when it was not calibrated."""
        return next((item for item in self.curves if (item.selection, item.refine) == (selection, refine)), None)

    def refined(self, trained: int) -> int:
        """Return the corrections of the poses that the curves were fitted to; ``trained`` are those of training."""
        return trained if self.refiner_iterations is None else self.refiner_iterations


def write_calibration(run: Path, calibration: Calibration) -> None:
    """Write ``calibration.yaml`` of a run folder."""
    text = yaml.safe_dump(to_mapping(calibration), sort_keys=False, default_flow_style=None, width=110)
    write_bytes(run / CALIBRATION, text.encode(), durable=True)


def read_calibration(run: Path) -> Calibration:
    """Return the curves of a run folder; none when it was never calibrated.

    Raises:
        TrainingError: The file is malformed.
    """
    if not os.path.lexists(run / CALIBRATION):
        return Calibration()
    try:
        return load_yaml(Calibration, run / CALIBRATION)
    except ConfigError as problem:
        raise TrainingError(str(problem)) from problem
