"""Disturb training samples so that few images teach much: hidden parts, turned clouds, changed colours, wrong masks.

Turning the cloud about its centre is the same as turning the camera: the visible surface stays the true one.
Masks become what a detector or a segmenter might have given in their place: each point of a crop knows how far its
pixel is from the outline, so that other outlines are a matter of comparing.
"""

import math
from typing import NamedTuple

import torch
from jaxtyping import Bool, Float, UInt8
from torch import Tensor

from warehouse_sim.estimators.pose.densefusion.networks.rotations import matrix_from_vector
from warehouse_sim.estimators.pose.densefusion.settings import AugmentConfig

LEAST_POINTS = 24
"""A sample is never left with fewer of its points."""
_HIDE_FRACTION = 0.4
"""Largest hidden fraction of the extent in the image."""
_LEAN = math.radians(2.5)
"""Standard deviation of how far what leans against gravity does, about each horizontal axis (rad)."""


class Noise(NamedTuple):
    """Random numbers of a batch, a row a sample; uniform in 0-1 but for the turn."""

    choice: Float[Tensor, "b 2"]
    """Which points are taken and how many are dropped."""
    hide: Float[Tensor, "b 4"]
    """What is hidden."""
    shift: Float[Tensor, "b 3"]
    """How the centre is shifted."""
    colour: Float[Tensor, "b 5"]
    """How colours change."""
    turn: Float[Tensor, "b 3"]
    """How the camera is turned; standard normal."""
    mask: Float[Tensor, "b k"] | None = None
    """How the mask is disturbed, where crops hold what is around it."""
    gravity: Float[Tensor, "b 1"] | None = None
    """Whether gravity is given, where the network reads it."""

    def rows(self, fraction: slice) -> "Noise":
        """Return the numbers of some of the samples."""
        return Noise(*(None if values is None else values[fraction] for values in self))  # type: ignore[arg-type]


def sample_noise(count: int, generator: torch.Generator, mask_width: int = 0, gravity: bool = False) -> Noise:
    """Return the random numbers of ``count`` samples.

    Args:
        count: Number of samples.
        generator: Source.
        mask_width: Numbers for the mask of each; 0 for none.
        gravity: Whether there is one for gravity, too.
    """
    uniform = torch.rand((count, 14), generator=generator, device=generator.device)
    normal = torch.randn((count, 3), generator=generator, device=generator.device)
    choice, hide, shift, colour = uniform.split((2, 4, 3, 5), dim=1)
    # Drawn last: what needs neither has the same numbers as before.
    wanted = {"mask": mask_width, "gravity": int(gravity)}
    more = {
        name: torch.rand((count, width), generator=generator, device=generator.device) if width else None
        for name, width in wanted.items()
    }
    return Noise(choice, hide, shift, colour, normal, **more)


def random_turns(
    noise: Float[Tensor, "b 3"],
    config: AugmentConfig,
    upright: Bool[Tensor, " b"] | None = None,
    leaning: Bool[Tensor, " b"] | None = None,
) -> Float[Tensor, "b 3 3"]:
    """Return random rotations in the camera frame (x right, y down, z forward).

    Args:
        noise: Standard normal numbers.
        config: How strong they are.
        upright: Which samples stand upright by their gravity, and are tilted by its error alone; none by default.
        leaning: Which of these lean against gravity; none by default.
    """
    turns = noise * torch.tensor([config.tilt, config.yaw, config.tilt], device=noise.device)
    if upright is not None:
        error = math.radians(config.gravity_error_deg)
        slight = noise * torch.tensor([error, config.yaw, error], device=noise.device)
        if leaning is not None:
            much = noise * torch.tensor([_LEAN, config.yaw, _LEAN], device=noise.device)
            slight = torch.where(leaning[:, None], much, slight)
        turns = torch.where(upright[:, None], slight, turns)
    return matrix_from_vector(turns)


def hide_points(
    points: Float[Tensor, "b p 3"],
    border_px: UInt8[Tensor, "b p"],
    present: Bool[Tensor, "b p"],
    noise: Float[Tensor, "b 4"],
    config: AugmentConfig,
) -> Bool[Tensor, "b p"]:
    """Return which points remain after an eroded mask and a random occluder.

    Args:
        points: Camera frame (m).
        border_px: Distance of each point's pixel to the mask's border.
        present: Which rows hold a point.
        noise: Uniform random numbers.
        config: How much is hidden.
    """
    taken_px = (noise[:, :1] * (config.erode_px + 1)).to(torch.uint8)
    present = _unless_too_few(present & (border_px > taken_px), present)
    angle = noise[:, 1:2] * 2.0 * torch.pi
    # A straight edge across the image: the side of it that lies first in a random direction is hidden.
    along = (points[..., 0] * angle.cos() + points[..., 1] * angle.sin()) / points[..., 2].clamp(min=1e-3)
    low = along.masked_fill(~present, torch.inf).amin(dim=1, keepdim=True)
    high = along.masked_fill(~present, -torch.inf).amax(dim=1, keepdim=True)
    fraction = noise[:, 2:3] * _HIDE_FRACTION
    edge = torch.where(noise[:, 3:] < config.hide_probability, low + (high - low) * fraction, -torch.inf)
    return _unless_too_few(present & (along > edge), present)


def disturb_colour(
    rgb: UInt8[Tensor, "b s s 3"], noise: Float[Tensor, "b 5"], config: AugmentConfig
) -> UInt8[Tensor, "b s s 3"]:
    """Return crops with random brightness, contrast and white balance."""
    change = ((noise * 2.0 - 1.0) * config.colour)[:, None, None]
    gain = (1.0 + change[..., :1]) * (1.0 + change[..., 2:] / 2.0)
    contrast = 1.0 + change[..., 1:2]
    values = rgb.float()
    offset = values.mean(dim=(1, 2), keepdim=True) * (1.0 - contrast) * gain
    # Rows of pixels times three channels as one axis, which a processor works through in one go.
    count, side = len(rgb), rgb.shape[1]
    factor, offset = (value.expand(-1, -1, side, -1).reshape(count, 1, side * 3) for value in (contrast * gain, offset))
    changed = torch.addcmul(offset, values.view(count, side, side * 3), factor).clamp_(0.0, 255.0).to(torch.uint8)
    return changed.view(rgb.shape)


def _unless_too_few(fewer: Bool[Tensor, "b p"], before: Bool[Tensor, "b p"]) -> Bool[Tensor, "b p"]:
    enough = fewer.sum(dim=1, keepdim=True) >= LEAST_POINTS
    return torch.where(enough, fewer, before)


_WAVES = 3
_WAVELENGTH_PX = 9.0, 70.0
_HOLE_FRACTION = 0.15, 0.5
_LEAST_KEPT = 0.5
"""Of a mask that is cut, so much of its extent remains."""
_MOST_NEIGHBOURS = 16
_COLUMNS = {"whether": 8, "grow": 1, "wander": 1 + 3 * _WAVES, "shift": 2, "hole": 4, "cut": 2,
            "merge": _MOST_NEIGHBOURS, "box": 4}  # fmt: skip
NOISE_WIDTH = sum(_COLUMNS.values())
"""Uniform random numbers that a sample needs."""


class Labelled(NamedTuple):
    """N points of each of b crops, and what is known of them."""

    signed_px: Float[Tensor, "b n"]
    """Pixels to the true outline, positive inside."""
    belongs: Bool[Tensor, "b n"]
    neighbour: Float[Tensor, "b n"]
    uv: Float[Tensor, "b n 2"]
    """Column and row from the window's upper left pixel (px)."""
    window_px: Float[Tensor, " b"]
    outline: Float[Tensor, "b o o"]
    """Pixels to the true outline over the window."""
    present: Bool[Tensor, "b n"]


class MaskErrors(NamedTuple):
    """What is wrong with disturbed masks; several of these may meet."""

    grow: float = 0.5
    """Fraction of the disturbed masks that are eroded or dilated by up to ``max_px``."""
    wander: float = 0.35
    """Fraction whose outline goes to and fro by up to ``max_px``, in waves."""
    shift: float = 0.25
    """Fraction that is shifted by up to ``max_px`` along each axis."""
    hole: float = 0.15
    """Fraction with a rectangular hole."""
    cut: float = 0.15
    """Fraction of which a side is missing, up to half."""
    merge: float = 0.3
    """Fraction that holds what lies in the crop of other targets, each with even odds."""
    box: float = 0.2
    """Fraction that is the box of the mask, each side moved by up to ``box_error``."""
    max_px: float = 4.0
    """How far an outline is off at most."""
    box_error: float = 0.08
    """How far sides of a box are off at most, as a fraction of its longer side."""


MASK_ERRORS = MaskErrors()


def disturbed_masks(
    known: Labelled, noise: Float[Tensor, "b k"], fraction: float, errors: MaskErrors = MASK_ERRORS
) -> Bool[Tensor, "b n"]:
    """Return which points a disturbed mask holds; one that would hold fewer than ``LEAST_POINTS`` stays the true one.

    Args:
        known: The points.
        noise: Uniform random numbers, 0-1.
        fraction: How many of the masks are disturbed, 0-1.
        errors: What is wrong with these.
    """
    gt_mask = (known.signed_px > 0) & known.present
    part = dict(zip(_COLUMNS, noise.split(tuple(_COLUMNS.values()), dim=1), strict=True))
    odds = [fraction, *errors[:7]]
    does = part["whether"] < torch.tensor(odds, device=noise.device)
    disturbed, grow, wander, shift, hole, cut, merge, box = (item[:, None] for item in does.unbind(dim=1))
    # Between a pixel inside and one outside lies the outline, half a pixel from both.
    distance = known.signed_px - 0.5 * known.signed_px.sign()
    distance = distance + grow * (2.0 * part["grow"] - 1.0) * (errors.max_px + 0.5)
    distance = distance + wander * _waves(known, part["wander"], errors.max_px)
    distance = distance + shift * _shifted(known, (2.0 * part["shift"] - 1.0) * errors.max_px)
    mask = distance > 0
    mask = mask | (merge & _neighbours(known, part["merge"]))
    mask = torch.where(box, _box(known, part["box"], errors.box_error), mask)
    mask = mask & ~(hole & _hole(known, part["hole"])) & ~(cut & _cut_off(known, part["cut"]))
    mask = mask & known.present
    keeps = disturbed & (mask.sum(dim=1, keepdim=True) >= LEAST_POINTS)
    return torch.where(keeps, mask, gt_mask)


def _waves(known: Labelled, noise: Tensor, max_px: float) -> Float[Tensor, "b n"]:
    """Return a field (px) of a few plane waves that is nowhere larger than ``max_px``."""
    strength, angle, phase, length = noise.split((1, _WAVES, _WAVES, _WAVES), dim=1)
    low, high = _WAVELENGTH_PX
    turn, wavelength = 2.0 * torch.pi * angle, low * (high / low) ** length
    along = known.uv @ torch.stack([turn.cos(), turn.sin()], dim=1)
    waves = (2.0 * torch.pi * (along / wavelength[:, None] + phase[:, None])).sin()
    return strength * max_px * waves.mean(dim=-1)


def _shifted(known: Labelled, shift_px: Float[Tensor, "b 2"]) -> Float[Tensor, "b n"]:
    """Return by how much (px) the distance to the outline changes at each point when the mask is shifted."""
    scale = 2.0 / known.window_px[:, None, None]
    here = (known.uv + 0.5) * scale - 1.0
    there = (known.uv + 0.5 - shift_px[:, None]) * scale - 1.0
    values = torch.nn.functional.grid_sample(
        known.outline[:, None], torch.stack([here, there], dim=1), padding_mode="border", align_corners=False
    )
    return values[:, 0, 1] - values[:, 0, 0]


def _neighbours(known: Labelled, noise: Float[Tensor, "b m"]) -> Bool[Tensor, "b n"]:
    taken = noise < 0.5
    # Number 0 is no neighbour.
    taken = torch.cat([torch.zeros_like(taken[:, :1]), taken[:, 1:]], dim=1)
    return torch.gather(taken, 1, known.neighbour.long())


def _extent(known: Labelled) -> tuple[Float[Tensor, "b 2"], Float[Tensor, "b 2"]]:
    """Return the corners (px) of the box of the points that are the object's."""
    out = ~(known.belongs & known.present)[..., None]
    low = known.uv.masked_fill(out, torch.inf).amin(dim=1)
    return low, known.uv.masked_fill(out, -torch.inf).amax(dim=1)


def _box(known: Labelled, noise: Float[Tensor, "b 4"], error: float) -> Bool[Tensor, "b n"]:
    low, high = _extent(known)
    moved = (2.0 * noise - 1.0) * error * (high - low).amax(dim=1, keepdim=True)
    low, high = (low + moved[:, :2])[:, None], (high + moved[:, 2:])[:, None]
    return ((known.uv >= low) & (known.uv <= high)).all(dim=-1)


def _hole(known: Labelled, noise: Float[Tensor, "b 4"]) -> Bool[Tensor, "b n"]:
    low, high = _extent(known)
    size = high - low
    middle = low + noise[:, :2] * size
    least, most = _HOLE_FRACTION
    half = size * (least + (most - least) * noise[:, 2:]) / 2.0
    return ((known.uv - middle[:, None]).abs() <= half[:, None]).all(dim=-1)


def _cut_off(known: Labelled, noise: Float[Tensor, "b 2"]) -> Bool[Tensor, "b n"]:
    """Return the points beyond a straight line across the mask."""
    angle = 2.0 * torch.pi * noise[:, :1]
    along = known.uv[..., 0] * angle.cos() + known.uv[..., 1] * angle.sin()
    out = ~(known.belongs & known.present)
    low = along.masked_fill(out, torch.inf).amin(dim=1, keepdim=True)
    high = along.masked_fill(out, -torch.inf).amax(dim=1, keepdim=True)
    return along > low + (high - low) * (_LEAST_KEPT + (1.0 - _LEAST_KEPT) * noise[:, 1:])
