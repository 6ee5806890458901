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
    "normals",
    "object_coordinates",
    "class_mask",
]
"""Colour and depth of the camera as read; visible and amodal masks of the targets; poses with boxes, visible fractions
and what hides how much; sweeps of all LiDARs; images of the second camera; what all other sensors read; colour and
depth without errors; normals of surfaces; places of visible target pixels in the box of their object; the class of
every pixel."""
OUTPUTS: tuple[Output, ...] = get_args(Output)
USUAL: tuple[Output, ...] = ("rgb", "depth", "masks", "amodal_masks", "poses", "lidar", "right", "readings")
"""What is wanted where nobody says it, as far as a rig has it."""
CODINGS: dict[Output, str] = {
    "normals": "unit normal of the surface, camera frame (x right, y down, z forward), in R G B: "
    "32768 + round(32767 n); 0 0 0 = nothing",
    "object_coordinates": "place of a visible target pixel in the box of its object, -size/2 = 0 and size/2 = 1 along "
    "x y z of the object frame, in R G B: 1 + round(65534 c); 0 0 0 = no target",
    "class_mask": "class of the pixel's object, as scene_class_mask.json names the values; 0 = nothing",
}
"""Images of exact data, made on request -> what their 16-bit PNGs say."""
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
