"""What a dataset can hold of an observation, by name: what a recipe may want, a format may need, a manifest says."""

from collections.abc import Iterable
from typing import Literal, get_args

Output = Literal[
    "rgb",
    "depth",
    "masks",
    "amodal_masks",
    "poses",
    "lidar",
    "right",
    "readings",
    "clean",
]
"""Colour and depth of the camera as read; visible and amodal masks of the targets; poses with boxes, visible fractions
and what hides how much; sweeps of all LiDARs; images of the second camera; what all other sensors read; colour and
depth without errors."""
OUTPUTS: tuple[Output, ...] = get_args(Output)
USUAL: tuple[Output, ...] = ("rgb", "depth", "masks", "amodal_masks", "poses", "lidar", "right", "readings")
"""What is wanted where nobody says it, as far as a rig has it."""
WantedOutput = Literal["default", Output]
"""An output, or the word for all of ``USUAL``."""


def wanted(listed: Iterable[WantedOutput]) -> tuple[Output, ...]:
    """Return the outputs that a list names, in the order of ``OUTPUTS``; an empty one names the usual ones."""
    named = set(listed)
    usual = USUAL if not named or "default" in named else ()
    return tuple(name for name in OUTPUTS if name in named or name in usual)


def in_words(names: Iterable[Output]) -> str:
    """Return outputs as a message lists them, in the order of ``OUTPUTS``."""
    found = set(names)
    return ", ".join(name for name in OUTPUTS if name in found)
