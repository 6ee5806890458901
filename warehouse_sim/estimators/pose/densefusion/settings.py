"""Settings of training a network of the family; free of torch, so that a command line can show them at once."""

from dataclasses import dataclass, field
from typing import Annotated, Literal

from warehouse_sim.learning.settings import LoopConfig
from warehouse_sim.ranges import Range, Share, ranged

Size = Literal["nano", "small", "full"]


@dataclass(frozen=True)
@ranged
class AugmentConfig:
    """How strongly training samples are disturbed."""

    yaw: Annotated[float, Range(0, 10, "rad")] = 0.15
    """Standard deviation of turns about the camera's vertical axis (rad), 0-10."""
    tilt: Annotated[float, Range(0, 10, "rad")] = 0.05
    """Standard deviation of turns about the camera's other two axes (rad), 0-10."""
    shift: Annotated[float, Range(0, 10, "m")] = 0.03
    """Largest shift of the centring point along each axis (m), 0-10."""
    hide_probability: Share = 0.3
    """Share of samples of which one side is hidden, 0-1."""
    hide_share: Share = 0.4
    """Largest hidden share of the extent in the image, 0-1."""
    erode_px: Annotated[int, Range(0, 100, "px")] = 2
    """Most pixels taken off the border of the mask, 0-100."""
    drop_share: Share = 0.7
    """Largest share of the points that is dropped at random, 0-1."""
    min_points: Annotated[int, Range(1, 65_536)] = 24
    """A sample is never left with fewer of its points, 1-65,536."""
    colour: Share = 0.25
    """Largest relative change of brightness, contrast and each channel, 0-1."""


SymmetryLoss = Literal["group", "none", "nearest"]


@dataclass(frozen=True)
@ranged
class LossConfig:
    """What training minimises; lengths are in half diameters of the object."""

    symmetry: SymmetryLoss = "group"
    """group: nearest equivalent of the true pose over the declared group, or over that of the shape where the network
    sees no colour; none: symmetric looks are told apart; nearest: nearest surface point for symmetric classes, as the
    original."""
    confidence_weight: Annotated[float, Range(0.000001, 1000)] = 0.08
    """Error up to which full confidence pays, in half diameters, 0.000001-1,000."""
    coordinate_weight: Annotated[float, Range(0, 1000)] = 0.01
    """Weight of the object coordinates against the pose that is fitted to them, 0-1,000."""
    nearest_hypotheses: Annotated[int, Range(1, 65_536)] = 16
    """Hypotheses of an object that the nearest-point loss looks at, 1-65,536."""
    nearest_points: Annotated[int, Range(1, 65_536)] = 128
    """Surface points of an object in the nearest-point loss, 1-65,536."""


Balance = Literal["crops", "objects", "classes"]


@dataclass(frozen=True)
@ranged
class TrainConfig(LoopConfig):
    """How an estimator of the family is trained."""

    size: Size = "nano"
    """Widths of the network: nano trains in minutes on a CPU, full has the original widths."""
    faithful: bool = False
    """Keep the original's quirks: image values of 0-255, log-softmax over the embedding, no batch normalisation,
    average pooling, separate heads."""
    objects: tuple[str, ...] = ()
    """Train only on objects of these names, with wildcards, or classes; all targets by default."""
    balance: Balance = "classes"
    """What is drawn equally often: classes (and in a class, objects by the root of their number), objects, or crops."""
    loss: LossConfig = field(default_factory=LossConfig)
    """What is minimised."""
    refiner_start: Share = 0.7
    """Share of the run after which the refiner is trained too, 0-1."""
    refiner_iterations: Annotated[int, Range(0, 100)] = 2
    """Corrections by the refiner, in training and prediction, 0-100."""
    workers: Annotated[int, Range(1, 1024)] = 2
    """Threads that decode images, 1-1,024."""
    augment: AugmentConfig = field(default_factory=AugmentConfig)
    """How samples are disturbed."""
