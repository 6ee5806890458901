"""Settings of tracking."""

from dataclasses import dataclass
from typing import Annotated

from warehouse_sim.ranges import Fraction, Range, ranged


@dataclass(frozen=True)
@ranged
class TrackConfig:
    """How the estimates of a drive become tracks; the priors on common errors have no source."""

    common_fraction: Fraction = 0.3
    """Fraction of an estimate's covariance that all estimates of a track have in common, 0-1: a CAD model that differs
    from the object, boards that hide, a side that is never seen. No number of images averages it out."""
    common_depth: Annotated[float, Range(0, 1, "m")] = 0.003
    """Error along the ray that a depth camera has in every image (m), 0-1, and"""
    common_depth_fraction: Annotated[float, Range(0, 0.1)] = 0.002
    """by which fraction of the range it grows, 0-0.1."""
    common_side: Annotated[float, Range(0, 1, "m")] = 0.002
    """The same across the ray (m), 0-1: where the camera is said to be mounted, and ..."""
    common_turn_deg: Annotated[float, Range(0, 10, "deg")] = 0.1
    """... how it is said to be turned (deg), 0-10."""
    drift: Annotated[float, Range(0, 1, "m")] = 0.0
    """What a second adds to the uncertainty of where an object is seen from (m at one second, growing with the root of
    time), 0-1; 0 for a vehicle that knows where it is."""
    gating_threshold: Annotated[float, Range(1, 1000)] = 22.46
    """Largest squared Mahalanobis distance between an estimate and its track, 1-1,000; 22.46 keeps 99.9 % of six
    numbers that are as uncertain as is said."""
    max_age: Annotated[float, Range(0, 3600, "s")] = 3.0
    """For so long (s), 0-3,600, a track is given where nothing was detected but its object should be in the image."""
