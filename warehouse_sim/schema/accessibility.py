"""Which sides of a pallet a truck can take it by, where it stands in its scene."""

from collections.abc import Mapping
from dataclasses import dataclass

FREE = "free"
"""What is said of a face that a truck can stand before and enter."""
UNDER_A_STACK = "under a stack"
"""Of a face that could be entered, were it not that another pallet stands on this one."""


@dataclass(frozen=True)
class Accessibility:
    """What geometry alone says of one object with pockets."""

    faces: Mapping[str, str]
    """Face ("-x", "+x", "-y", "+y") -> ``FREE``, or why no truck takes it there: "blocked by rack", ..."""
    stacked: bool = False
    """Whether it stands on another pallet or another one on it, itself or its load."""
