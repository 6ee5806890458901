"""Settings of the training loop and of streams; free of torch, so that a command line can show them at once."""

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from typing import Annotated, ClassVar, Literal, Self

from warehouse_sim.ranges import Range, Seed, ranged

Progress = Callable[[float, str], None]
"""Takes the fraction that is done (0-1) and one line that says what is going on."""


@dataclass(frozen=True)
@ranged
class LoopConfig:
    """How a network is trained; it stops at ``max_minutes`` or ``max_steps``, whichever comes first."""

    max_minutes: Annotated[float, Range(0.001, 100_000, "minutes")] | None = 5.0
    """Wall time of the whole run with reading, validation and saving (minutes), 0.001-100,000; none for no limit. When
    fewer than 100 steps will fit, a warning at the beginning says so."""
    max_steps: Annotated[int, Range(1, 1_000_000_000)] | None = None
    """Optimiser steps, 1-1,000,000,000; none for no limit."""
    batch: Annotated[int, Range(1, 65_536)] = 16
    """Samples a step, 1-65,536."""
    learning_rate: Annotated[float, Range(0.000000001, 10)] = 1.5e-3
    """Peak learning rate, 0.000000001-10; falls along a cosine to a hundredth."""
    ema: Annotated[float, Range(0, 0.999999)] = 0.999
    """Fraction of the running average of the weights that stays at each step, 0-0.999999; validation and the run folder
    have the average. 0 for the last weights themselves."""
    validations: Annotated[int, Range(1, 10_000)] = 8
    """Validations, checkpoints included, spread evenly over the run, 1-10,000."""
    precision: Literal["auto", "32", "bf16"] = "auto"
    """Arithmetic of the networks; auto takes bf16 where the processor has it in hardware."""
    devices: Annotated[int, Range(1, 1024)] = 1
    """Processes that share each step, one a GPU where there are any, else on the CPU, 1-1,024; divides ``batch``."""
    threads: Annotated[int, Range(1, 1024)] | None = None
    """CPU threads of each process, 1-1,024; by default one for nano, which more would slow down, else its fraction of
    all processors."""
    seed: Seed = 0
    """Decides initial weights, order and disturbance of the samples, >= 0."""

    warmup_steps: ClassVar[int] = 100
    """Steps over which the learning rate rises, at most a tenth of the run."""
    weight_decay: ClassVar[float] = 1e-4
    """Decoupled weight decay of AdamW."""
    clip_norm: ClassVar[float] = 1.0
    """Largest norm of the gradient."""

    def __post_init__(self) -> None:
        if self.max_minutes is None and self.max_steps is None:
            raise ValueError("training never ends: set max_minutes or max_steps")
        if self.batch % self.devices:
            raise ValueError(f"batch {self.batch} cannot be shared evenly by {self.devices} devices")
        if self.fed_by and self.devices > 1:
            raise ValueError(f"a stream feeds one process, not {self.devices}: leave out stream.recipe or devices")

    def defaults(self) -> Self:
        """Return the settings of whoever names none, to go on with a run."""
        return type(self)()

    @property
    def size(self) -> str:
        """Name of the network's size; a setting of the networks that have several."""
        return ""

    @property
    def fed_by(self) -> "StreamConfig | None":
        """The stream that is trained on; None where it is the train split."""
        return None


@dataclass(frozen=True)
@ranged
class StreamConfig:
    """Observations that are made while a network trains on them, in place of a train split.

    Steps draw from a window of ``window`` observations in shuffled rounds, as of a dataset that holds them, and bring
    in ``fresh`` new ones each, of which an eighth of a window enters at once. So a step depends on its number alone:
    neither on how fast observations are made nor on whether the run was interrupted.
    """

    recipe: str = ""
    """Name or path of the recipe whose observations are trained on; by default the train split of the data is."""
    seed: Seed = 1
    """Seed of its scenes, >= 0; another one than that of the data, whose val split they would show."""
    window: Annotated[int, Range(1, 1_000_000)] = 256
    """Observations of which a step draws, 1-1,000,000; the first step waits for so many. Up to an eighth more are in
    memory."""
    fresh: Annotated[float, Range(0, 1000)] = 0.25
    """New observations that each step brings in, of which as many leave, 0-1,000; fractions add up."""
    workers: Annotated[int, Range(1, 1024)] = 1
    """Processes that make observations while the network trains, 1-1,024."""

    def __post_init__(self) -> None:
        changed = [item.name for item in fields(self) if getattr(self, item.name) != item.default]
        if changed and not self.recipe:
            raise ValueError(f"stream.{changed[0]} is of a stream that no recipe is named for: give stream.recipe, too")


@dataclass(frozen=True)
@ranged
class StreamedConfig(LoopConfig):
    """How a network is trained that may be fed by a stream."""

    stream: StreamConfig = field(default_factory=StreamConfig)
    """What is trained on in place of the train split, where a recipe is named."""

    @property
    def fed_by(self) -> StreamConfig | None:
        """The stream that is trained on; None where it is the train split."""
        return self.stream if self.stream.recipe else None
