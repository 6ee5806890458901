"""Settings of training; free of torch, so that a command line can show them at once."""

from dataclasses import dataclass, field
from typing import Annotated, Literal

from warehouse_sim.ranges import Range, Seed, Share, ranged

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
class TrainConfig:
    """How an estimator is trained; it stops at ``max_minutes`` or ``max_steps``, whichever comes first."""

    size: Size = "nano"
    """Widths of the network: nano trains in minutes on a CPU, full has the original widths."""
    faithful: bool = False
    """Keep the original's quirks: image values of 0-255, log-softmax over the embedding, no batch normalisation,
    average pooling, separate heads."""
    max_minutes: Annotated[float, Range(0.001, 100_000, "minutes")] | None = 5.0
    """Wall time of the whole run with reading, validation and saving (minutes), 0.001-100,000; none for no limit. When
    fewer than 100 steps will fit, a warning at the beginning says so."""
    max_steps: Annotated[int, Range(1, 1_000_000_000)] | None = None
    """Optimiser steps, 1-1,000,000,000; none for no limit."""
    batch: Annotated[int, Range(1, 65_536)] = 16
    """Samples a step, 1-65,536."""
    learning_rate: Annotated[float, Range(0.000000001, 10)] = 1.5e-3
    """Peak learning rate, 0.000000001-10; falls along a cosine to a hundredth."""
    warmup_steps: Annotated[int, Range(0, 1_000_000_000)] = 100
    """Steps over which the learning rate rises, at most a tenth of the run, 0-1,000,000,000."""
    weight_decay: Annotated[float, Range(0, 10)] = 1e-4
    """Decoupled weight decay of AdamW, 0-10."""
    clip_norm: Annotated[float, Range(0.000001, 1_000_000)] = 1.0
    """Largest norm of the gradient, 0.000001-1,000,000."""
    ema: Annotated[float, Range(0, 0.999999)] = 0.999
    """Share of the running average of the weights that stays at each step, 0-0.999999; validation and the run folder
    have the average. 0 for the last weights themselves."""
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
    validations: Annotated[int, Range(1, 10_000)] = 8
    """Validations, checkpoints included, spread evenly over the run, 1-10,000."""
    precision: Literal["auto", "32", "bf16"] = "auto"
    """Arithmetic of the networks; auto takes bf16 where the processor has it in hardware."""
    devices: Annotated[int, Range(1, 1024)] = 1
    """Processes that share each step, one a GPU where there are any, else on the CPU, 1-1,024; divides ``batch``."""
    threads: Annotated[int, Range(1, 1024)] | None = None
    """CPU threads of each process, 1-1,024; by default one for nano, which more would slow down, else its share of all
    processors."""
    workers: Annotated[int, Range(1, 1024)] = 2
    """Threads that decode images, 1-1,024."""
    seed: Seed = 0
    """Decides initial weights, order and disturbance of the samples, >= 0."""
    augment: AugmentConfig = field(default_factory=AugmentConfig)
    """How samples are disturbed."""

    def __post_init__(self) -> None:
        if self.max_minutes is None and self.max_steps is None:
            raise ValueError("training never ends: set max_minutes or max_steps")
        if self.batch % self.devices:
            raise ValueError(f"batch {self.batch} cannot be shared evenly by {self.devices} devices")
