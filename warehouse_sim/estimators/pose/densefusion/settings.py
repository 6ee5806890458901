"""Settings of cutting crops and of training; free of torch, so that a command line can show them at once."""

from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Annotated, Any, ClassVar, Literal, TypeVar

from warehouse_sim.estimators.api import LeastVisible
from warehouse_sim.learning.settings import StreamedConfig
from warehouse_sim.ranges import Fraction, Range, ranged

_MOST_SIDE_PX = 181
"""Pixels of a crop are numbered in 16 bits."""
_RIM_FRACTION = 0.08
"""Least width of the rim that is kept about a mask's box, as a fraction of its longer side: as much as boxes are off
of large objects."""
_STORED_MARGIN = 0.5
"""Space around the mask in crops with surroundings, as a fraction of its longer side: half a neighbour on each side."""


@dataclass(frozen=True)
@ranged
class CropConfig:
    """How targets are cut out of images."""

    side_px: Annotated[int, Range(1, _MOST_SIDE_PX, "px")] | None = None
    """Side of the square crops in pixels, 1-181; none when the network reads the cloud alone."""
    rgb: bool = True
    """Keep colour in the square crop, where there is one."""
    depth: bool = False
    """Keep depth in the square crop, where there is one."""
    stored_points: Annotated[int, Range(1, 65_536)] = 1024
    """Most points kept of one target, 1-65,536; each training step draws its own from them."""
    surround_px: Annotated[int, Range(0, 1000, "px")] = 0
    """Least width of the rim about the mask's box whose pixels are kept, too, 0-1,000; 0 keeps those of the mask
    alone."""

    min_points: ClassVar[int] = 32
    """Targets with fewer depth readings are left out."""
    min_visible_fraction: ClassVar[float] = 0.1
    """Targets less visible than this are left out."""
    margin: ClassVar[float] = 0.1
    """Space around the mask in the square crop, as a fraction of its longer side."""

    @property
    def has_surroundings(self) -> bool:
        """Whether crops hold pixels around the mask, each with what the mask says of it."""
        return self.surround_px > 0

    @property
    def stored_side_px(self) -> int | None:
        """Side of the square crops as they are kept: of a crop with surroundings the network sees a part."""
        if self.side_px is None or not self.has_surroundings:
            return self.side_px
        return min(self.side_px * 3 // 2, _MOST_SIDE_PX)

    @property
    def stored_margin(self) -> float:
        """Space around the mask in the square crop as it is kept: masks that are too large find room in it."""
        return _STORED_MARGIN if self.has_surroundings else self.margin

    def rim_px(self, width: int, height: int) -> int:
        """Return how wide the rim about a box of this size (px) is."""
        return max(self.surround_px, round(_RIM_FRACTION * max(width, height)))

    @property
    def reads_rgb(self) -> bool:
        """Whether crops hold colour."""
        return self.side_px is not None and self.rgb

    @property
    def reads_depth(self) -> bool:
        """Whether crops hold depth."""
        return self.side_px is not None and self.depth

    @property
    def min_visible(self) -> LeastVisible:
        """Which targets of a dataset are cut out."""
        return LeastVisible(self.min_visible_fraction, self.min_points)

    def __post_init__(self) -> None:
        if self.side_px is not None and not (self.rgb or self.depth):
            raise ValueError(f"a square crop of {self.side_px} px must hold rgb or depth; leave it out for neither")


Size = Literal["nano", "small", "full"]
Settings = TypeVar("Settings", bound=Any)


@dataclass(frozen=True)
@ranged
class MaskNoiseConfig:
    """How masks are disturbed in training, where crops hold what is around them; ``crops.augment`` says how."""

    fraction: Fraction = 0.0
    """Fraction of samples with a disturbed mask, 0-1; the others keep the true one."""


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
    hide_probability: Fraction = 0.3
    """Fraction of samples of which one side is hidden, 0-1."""
    erode_px: Annotated[int, Range(0, 100, "px")] = 2
    """Most pixels taken off the border of the mask, 0-100."""
    drop_fraction: Fraction = 0.7
    """Largest fraction of the points that is dropped at random, 0-1."""
    colour: Fraction = 0.25
    """Largest relative change of brightness, contrast and each channel, 0-1."""
    masks: MaskNoiseConfig = field(default_factory=MaskNoiseConfig)
    """How masks are disturbed, where crops hold what is around them."""
    gravity_drop: Fraction = 0.0
    """Fraction of samples whose gravity is kept from a network that reads it, 0-1."""
    gravity_error_deg: Annotated[float, Range(0, 45, "deg")] = 0.0
    """Standard deviation of the error of gravity about each horizontal axis, 0-45; such samples are not tilted by
    ``tilt``."""
    lean_fraction: Fraction = 0.0
    """Fraction of the samples with gravity that lean against it all the same, as a pallet on debris does,
    0-1."""


Distance = Literal["surface", "chamfer", "chamfer-squared"]
SymmetryLoss = Literal["group", "shape", "none", "nearest"]


@dataclass(frozen=True)
@ranged
class LossConfig:
    """What training minimises; lengths are in half diameters of the object, unless ``unit`` says metres."""

    distance: Distance = "surface"
    """surface: of the same surface points under both poses, or as ``symmetry`` says; chamfer: mean distance from each
    surface point to the nearest one of the other pose, both ways, which needs no symmetry; chamfer-squared: of its
    squares, as the dissertation, which has ``unit`` metres and ``confidence_weight`` 0.015."""
    unit: Literal["half-diameters", "metres"] = "half-diameters"
    """Of distances (squared: its square) and ``confidence_weight``; the original and the dissertation have metres."""
    symmetry: SymmetryLoss = "group"
    """group: nearest equivalent of the true pose over the declared group, or over that of the shape where the network
    sees no colour; shape: over that of the shape in any case, for crops too small to tell print; none: symmetric looks
    are distinguished; nearest: nearest surface point for symmetric classes, as the original."""
    confidence_weight: Annotated[float, Range(0.000001, 1000)] = 0.08
    """Error up to which full confidence pays, in ``unit``, 0.000001-1,000."""

    @property
    def reads_surface(self) -> bool:
        """Whether points of the surface are compared, not its moments."""
        return self.distance != "surface" or self.symmetry == "nearest"


Balance = Literal["crops", "objects", "classes"]
Phase = Literal["joint", "apart", "refiner"]


@dataclass(frozen=True)
@ranged
class TrainConfig(StreamedConfig):
    """How an estimator of the family is trained."""

    size: Size = "nano"
    """Widths of the network: nano trains in minutes on a CPU, full has the original widths."""
    paper: bool = False
    """Keep the original's quirks: image values of 0-255, log-softmax over the embedding, no batch normalisation,
    corners aligned, average pooling, a refiner that pools both layers, separate heads."""
    surroundings: bool = False
    """Give the network what is around the mask, too, each point labelled in or out, and let it say which points are
    the object's."""
    upright: bool = False
    """Turn clouds upright where gravity is known, and tell the network where it was."""
    objects: tuple[str, ...] = ()
    """Train only on objects of these names, with wildcards, or classes; all targets by default."""
    balance: Balance = "classes"
    """What is drawn equally often: classes (and in a class, objects by the root of their number), objects, or crops."""
    loss: LossConfig = field(default_factory=LossConfig)
    """What is minimised."""
    phase: Phase = "joint"
    """joint: after ``refiner_start`` the refiner is trained with the rest; apart: from there on it is trained alone, as
    the original's; refiner: nothing else is trained, on top of the weights that training begins with."""
    refiner_start: Fraction = 0.7
    """Fraction of the run after which the refiner is trained too, or alone, 0-1."""
    refiner_iterations: Annotated[int, Range(0, 100)] = 2
    """Corrections by the refiner in training, and in prediction where nothing else is said, 0-100."""
    points: Annotated[int, Range(8, 65_536)] | None = None
    """Points of a sample that a step of training sees, 8-65,536; by default as many as in prediction. Fewer make steps
    cheaper: the points of one object say much the same."""
    workers: Annotated[int, Range(1, 1024)] = 2
    """Threads that decode images, 1-1,024."""
    augment: AugmentConfig = field(default_factory=AugmentConfig)
    """How samples are disturbed."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.phase != "joint" and self.refiner_iterations == 0:
            raise ValueError(f"phase {self.phase} trains the refiner: refiner_iterations must be 1 or more")


Preset = Literal["plain", "robust"]
PRESETS: dict[Preset, TrainConfig] = {
    "plain": TrainConfig(),
    # 0.3 degrees: what an accelerometer of a few milli-g of bias says of a vehicle that stands.
    "robust": TrainConfig(
        surroundings=True,
        upright=True,
        augment=AugmentConfig(
            masks=MaskNoiseConfig(fraction=0.75), gravity_drop=0.3, gravity_error_deg=0.3, lean_fraction=0.15
        ),
    ),
}
"""Settings by name: plain trains on ground-truth masks; robust makes networks for masks with errors and tilted
cameras."""


def with_preset(config: TrainConfig, name: Preset) -> TrainConfig:
    """Return settings whose values that are left at their defaults are those of a preset."""
    return _filled(config, PRESETS[name])


def _filled(given: Settings, preset: Settings) -> Settings:
    default, found = type(given)(), {}
    for item in fields(given):
        value, other = getattr(given, item.name), getattr(preset, item.name)
        found[item.name] = _filled(value, other) if is_dataclass(value) else value
        if value == getattr(default, item.name):
            found[item.name] = other
    return replace(given, **found)
