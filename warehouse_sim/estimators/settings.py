"""Settings of prediction; free of torch, so that a command line can show them at once."""

from dataclasses import dataclass, field
from typing import Annotated, Literal

from warehouse_sim.dataset.reader import Calibration
from warehouse_sim.estimators.gravity import GravitySource
from warehouse_sim.estimators.lidar.source import DepthSource
from warehouse_sim.estimators.pose.choose import Selection
from warehouse_sim.estimators.pose.icp.refine import IcpConfig
from warehouse_sim.estimators.tracking.settings import TrackConfig
from warehouse_sim.ranges import Range, Seed, ranged

Refinement = Literal["none", "icp", "verify"]


@dataclass(frozen=True)
@ranged
class PredictConfig:
    """How poses are estimated."""

    detections: str = "auto"
    """Where detections come from: auto leaves it to estimators that find objects themselves, and is ground truth for
    others. ground truth takes a dataset's ground-truth visible masks, as BOP's localisation with given masks; gt-boxes
    the boxes about these; else a detector or a segmenter by name or run folder, or a file of detections (COCO's or
    BOP's results, a folder of YOLO's labels), or several joined by +, each working on what the one before found
    (gt-boxes+cluster)."""
    depth: DepthSource | None = None
    """Whose depth estimators see: the camera's, the main LiDAR's filled up (lidar), or only where the LiDAR has points
    (lidar-sparse). None takes what the estimator was made for, which is the camera's where it does not say."""
    objects: tuple[str, ...] = ()
    """Names of the objects that there are (epal1), where detections do not say which one they are; by default those of
    a detection's class that dataset and estimator know. Who knows what pallets stand in a hall says so."""
    selection: Selection = "argmax"
    """How one pose is chosen from those that the points propose."""
    refiner_iterations: Annotated[int, Range(0, 100)] | None = None
    """Corrections by the network's own refiner, before what ``refine`` names, 0-100; by default as many as val said
    help when the run was calibrated, else those of its training."""
    refine: Refinement = "none"
    """What follows the network: nothing; point-to-plane ICP against the CAD surface; or verification: ICP from several
    poses, of the network, turned, and fitted to the points alone, of which the depth image chooses."""
    uncertainty: bool = True
    """Whether estimates are looked at afterwards, where that was fitted: a score that ranks, covariance, bound."""
    reject: Annotated[float, Range(0, 1)] | None = None
    """Largest risk (1 - score) of an estimate that is given, 0-1; others get the score 0 and no row in the file of
    poses. None gives all."""
    reject_blocked: bool = False
    """Whether estimates are rejected, too, where readings lie in an opening of the object or close before it: a pallet
    whose pocket is blocked, or something that is no pallet."""
    calibration: Calibration = "true"
    """What estimators are told of the rig: the true calibration, or what the rig states, which ``sensors.calibration``
    of the recipe lets differ."""
    gravity: GravitySource = "rig"
    """Where down is, for what asks for it: as the rig's place in the world says, as the floor in sight, or unknown."""
    images_at_once: Annotated[int, Range(1, 1024)] = 8
    """Images whose targets pass the network together, 1-1,024."""
    seed: Seed = 0
    """Decides which points are drawn, >= 0."""
    device: Literal["auto", "cpu", "cuda"] = "auto"
    """Where the network runs; auto takes a GPU if there is one."""
    threads: Annotated[int, Range(1, 1024)] | None = None
    """Processor threads of the network, 1-1,024; by default one for small networks, which gain little from more and
    wait long for them on a busy machine, and torch's own number for large ones."""
    time_of_flight: bool = False
    """Whether the depth camera measures time of flight. Level surfaces along which such a camera looks seem centimetres
    too far, since light bounces; where gravity is known they are believed the less, the flatter it looks along them.
    Objects that truly lean by some degrees are then taken for upright. For ``refine`` icp and verify."""
    track: bool = False
    """Whether the images of a drive are seen one after the other: poses are filtered in the world with the covariance
    of each, and objects that are lost for some images are given where they were."""
    tracking: TrackConfig = field(default_factory=TrackConfig)
    """Settings of that."""
    icp: IcpConfig = field(default_factory=IcpConfig)
    """Settings of the ICP."""
