"""A row of a result: one number with its interval. It needs nothing else, so that results can be read anywhere."""

from dataclasses import dataclass
from typing import Literal

Table = Literal[
    "scores",
    "effects",
    "curves",
    "spread",
    "detection",
    "confusion",
    "precision",
    "faces",
    "simulated",
    "driven",
    "negatives",
    "time",
]
Place = tuple[Table, str, str, str, str]
"""Table, estimator, condition, group and metric of a row."""

WORST = "worst layout"
"""Condition of the rows that state how good everybody is where it is worst."""
HEADLINE = "dock_0mm"
"""What decides which layout that is."""
SECONDS = "seconds_per_image"
"""The metric of run times."""


@dataclass(frozen=True)
class Row:
    """One number."""

    table: Table
    """Which table it stands in."""
    estimator: str
    """Who answered."""
    condition: str
    """What was evaluated."""
    group: str
    """Of which ground truths, "all" or a group's label."""
    metric: str
    """What was counted; shares are 0-1, times in seconds."""
    value: float
    interval: tuple[float, float]
    """95 %: over scenes, and over trainings where there are several."""
    n: int
    """Ground truths that were counted, or pairs of them, or detections."""
    scenes: int
    """Scenes that they are in."""
    trainings: int = 0
    """Number of trainings; 0 without training. With 1 the interval does not cover other trainings."""
    against: str = ""
    """What a paired effect is against; empty elsewhere."""
    machine: str = ""
    """Of a time: processor and cores that it was measured on; empty elsewhere, and where nobody stated it."""

    @property
    def over(self) -> str:
        """What the interval covers, in words."""
        counted = f"{self.scenes} scene" if self.scenes == 1 else f"{self.scenes} scenes"
        if not self.trainings:
            return counted
        return f"{counted}, {'one training' if self.trainings == 1 else f'{self.trainings} trainings'}"
