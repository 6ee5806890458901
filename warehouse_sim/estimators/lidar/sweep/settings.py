"""Settings of the detector that looks at sweeps, and its name; free of torch, so that a command line is quick."""

from dataclasses import dataclass, field
from typing import Annotated, ClassVar

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.estimators.detectors.settings import BoxTrainingConfig
from warehouse_sim.learning.trainable import TrainableNetwork
from warehouse_sim.ranges import Fraction, Range, ranged

CELL = 32
"""Edges of what a network reads are multiples of this (px)."""


@dataclass(frozen=True)
@ranged
class RangeImageConfig:
    """Which directions of a sweep are which pixels: columns are azimuths all around, rows elevations."""

    columns: Annotated[int, Range(128, 8192, "px")] = 1024
    """Columns of a whole turn, 128-8,192, a multiple of 32."""
    rows: Annotated[int, Range(32, 4096, "px")] = 192
    """Rows between the elevations, 32-4,096, a multiple of 32."""
    elevation_deg: Annotated[tuple[float, float], Range(-89, 89, "deg")] = (-25.0, 7.0)
    """Least and greatest elevation above the LiDAR's horizon (deg), -89 to 89; what lies beyond is not seen."""

    def __post_init__(self) -> None:
        if self.columns % CELL or self.rows % CELL:
            raise ValueError(f"columns and rows must be multiples of {CELL}, found {self.columns} and {self.rows}")
        if self.elevation_deg[0] >= self.elevation_deg[1]:
            raise ValueError(f"elevation_deg must rise, found {self.elevation_deg}")


@dataclass(frozen=True)
@ranged
class SweepAugmentConfig:
    """How strongly sweeps are disturbed in training; each sample is turned by any azimuth."""

    window: Annotated[int, Range(64, 8192, "px")] = 512
    """Columns of the sector that a sample shows, 64-8,192, a multiple of 32 and at most half a turn."""
    mosaic: Fraction = 0.3
    """Fraction of samples whose halves are of different sweeps, 0-1."""
    zoom: Annotated[float, Range(1, 2)] = 1.25
    """Largest factor by which sectors are enlarged or shrunk, and ranges divided, 1-2."""
    shift: Annotated[float, Range(0, 1000, "px")] = 6.0
    """How far sectors are shifted up or down at most (px), as a LiDAR that leans sees them, 0-1,000."""
    flip: Fraction = 0.5
    """Fraction of sectors that are mirrored, 0-1."""
    noise: Annotated[float, Range(0, 1, "m")] = 0.015
    """Largest standard deviation of more noise on ranges (m), 0-1."""
    holes: Annotated[int, Range(0, 1000)] = 4
    """Most rectangles without readings, 0-1,000."""
    floor_unknown: Fraction = 0.1
    """Fraction of samples that do not say where the floor is, 0-1."""
    floor_error: Annotated[float, Range(0, 1, "m")] = 0.02
    """Standard deviation of an error of the floor's height (m), 0-1."""

    def __post_init__(self) -> None:
        if self.window % CELL:
            raise ValueError(f"window must be a multiple of {CELL}, found {self.window}")


@dataclass(frozen=True)
@ranged
class WantedInSweepConfig:
    """Which objects a detector is to find in a sweep; it is neither taught nor scored on others."""

    points: Annotated[float, Range(1, 1_000_000)] = 30
    """Least number of its points, 1-1,000,000."""
    fraction: Fraction = 0.3
    """Least fraction of its box that is in the sector which a training sample shows, 0-1."""


@dataclass(frozen=True)
@ranged
class SweepDetectorConfig(BoxTrainingConfig):
    """How a detector of objects in sweeps is trained."""

    sweep: RangeImageConfig = field(default_factory=RangeImageConfig)
    """Which directions are seen, and how finely."""
    wanted: WantedInSweepConfig = field(default_factory=WantedInSweepConfig)
    """Which objects are to be found."""
    augment: SweepAugmentConfig = field(default_factory=SweepAugmentConfig)
    """How sweeps are disturbed."""

    def __post_init__(self) -> None:
        if 2 * self.augment.window > self.sweep.columns:
            raise ValueError(
                f"augment.window {self.augment.window} must be half of {self.sweep.columns} columns or less"
            )

    def is_wanted(self, labels: Float[np.ndarray, "k 8"]) -> Bool[np.ndarray, " k"]:
        """Return which labels, as ``rows.SWEEP_LABEL`` names them, are to be found."""
        wanted: Bool[np.ndarray, " k"] = (labels[:, 5] >= self.wanted.fraction) & (labels[:, 6] >= self.wanted.points)
        return wanted


@dataclass(frozen=True)
class TrainableSweepDetector(TrainableNetwork):
    """A detector of objects in sweeps."""

    settings: SweepDetectorConfig = SweepDetectorConfig()

    job: ClassVar[str] = "warehouse_sim.estimators.lidar.sweep.train:SweepJob"
    opens: ClassVar[str] = "warehouse_sim.estimators.lidar.sweep.estimator:TrainedSweepDetector"


DETECTOR_SWEEP = TrainableSweepDetector("detector-sweep", "finds objects in whole LiDAR sweeps", "LiDAR sweep")
