"""Settings of training on a stream instead of files; free of torch, so that a command line can show them at once."""

from dataclasses import dataclass
from typing import Annotated

from warehouse_sim.ranges import Range, Seed, ranged


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
    """Processes that make observations, 1-1,024; 1 makes them in that of the training, which then waits."""
