"""Settings of prediction; free of torch, so that a command line can show them at once."""

from dataclasses import dataclass, replace
from typing import Annotated, Literal

from warehouse_sim.dataset.reader import Calibration
from warehouse_sim.estimators.gravity import GravitySource
from warehouse_sim.estimators.pose.choose import Selection
from warehouse_sim.ranges import Range, Seed, ranged

DepthSource = Literal["camera", "lidar", "lidar-sparse"]
"""Whose depth is seen: the camera's own, the main LiDAR's filled up, or only where it has points."""
Refinement = Literal["none", "icp", "verify"]
IMAGES_AT_ONCE = 8
"""Images per network call."""


@dataclass(frozen=True)
@ranged
class PredictConfig:
    """How poses are estimated."""

    detections: str = "auto"
    """Where detections come from: auto (the estimator itself where it finds objects, else gt), gt, gt-boxes, a detector
    or segmenter by name or run folder, or a file of detections; joined by + they work one after the other."""
    depth: DepthSource | None = None
    """Depth that the estimator sees: camera, lidar (the sweep's depth, filled up) or lidar-sparse; by default what the
    estimator was made for."""
    objects: tuple[str, ...] = ()
    """Names of the objects present (epal1), where detections name only a class; by default those of the class that
    dataset and estimator know."""
    selection: Selection | None = None
    """How one pose is selected from those of the points; by default consensus."""
    refiner_iterations: Annotated[int, Range(0, 100)] | None = None
    """Corrections by the network's own refiner where one was trained, 0-100; by default those of its calibration, else
    of its training."""
    refine: Refinement | None = None
    """What refines the pose: nothing, point-to-plane ICP, or multi-hypothesis ICP with depth verification (verify); by
    default verify, or none where the estimator has no CAD surfaces."""
    uncertainty: bool = True
    """Add a score that ranks, a covariance and an error bound, where they were fitted for these settings."""
    reject: Annotated[float, Range(0, 1)] | None = None
    """Reject estimates whose risk (1 - score) is higher, 0-1; they are not written. By default none is rejected."""
    reject_blocked: bool = False
    """Reject estimates whose openings are blocked: a pallet with something in its pocket, or no pallet."""
    calibration: Calibration = "true"
    """Calibration that estimators get: the true one, or the nominal one of ``sensors.calibration`` in the recipe."""
    gravity: GravitySource = "rig"
    """Source of the gravity direction: the rig's pose, the floor in the depth image, or none."""
    seed: Seed = 0
    """Seed of the points that are sampled, >= 0."""
    device: Literal["auto", "cpu", "cuda"] = "auto"
    """Where the network runs; auto takes a GPU if there is one."""
    threads: Annotated[int, Range(1, 1024)] | None = None
    """Processor threads of the network, 1-1,024; by default one for small networks, torch's number for large."""
    time_of_flight: bool = False
    """Correct for a time-of-flight camera: level surfaces at grazing angles count less in ICP and verification.
    Objects are then assumed upright."""
    track: bool = False
    """Filter the poses of each drive in the world frame, with their covariances, and predict hidden objects."""

    def with_stages(self, has_surfaces: bool = True) -> "PredictConfig":
        """Return the settings of a network, with the best selection and refinement where none is given.

        Args:
            has_surfaces: Whether it has the CAD surfaces that refinement needs.
        """
        best: Refinement = "verify" if has_surfaces else "none"
        return replace(self, selection=self.selection or "consensus", refine=self.refine or best)

    def without_stages(self) -> "PredictConfig":
        """Return the settings of an estimator that selects and refines in its own way."""
        selection, refine = self.way
        return replace(self, selection=selection, refine=refine)

    @property
    def way(self) -> tuple[Selection, Refinement]:
        """Selection and refinement; argmax and none where nothing is given or filled in."""
        return self.selection or "argmax", self.refine or "none"
