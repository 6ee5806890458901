"""What is on a floor and no part of it: paint, and what years of traffic leave.

Frame of all: origin at the centre of the bounding box, z up, the underside on the floor; none has collision boxes.
Lines of at least 50 mm mark traffic routes (ASR A1.3, 5.3); 100 mm is common. A line is sampled 1 mm thick, within the
1.5-3 mm of thermoplastic marking; a tyre mark, which has no thickness, as 0.4 mm so that it shows from afar.

What is thinner than paint, tracks, stains, repaired patches and water, lets the floor shine through: its materials are
films, so that depth, instance ids and labels are those of the floor. Every pass of a truck is a band of its own, and
where passes cross they add up, as they do on a floor.
"""

from functools import cache
from typing import Literal

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog.building.floor_litter import THICK, band, floor_litter
from warehouse_sim.catalog.parts import box_part, fused, mesh_part, model_of
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import rotation_z
from warehouse_sim.geometry.solids import prism
from warehouse_sim.schema import ObjectModel, Part

LINE_WIDTH = 0.1
"""Width of a floor line (m)."""
LINE_LENGTHS_MM = (1000, 3000, 6000)
"""Lengths of the lines in the catalog."""
PAINT = 0.001
"""Thickness of paint (m)."""
TYRE_TRACK = 0.9
"""Distance between the two tracks of a counterbalance truck's front wheels (m)."""

_MARK_WIDTH, _TYRETHICK = 0.14, 0.0004
_COLOURS = ("yellow", "white")
LINES = {f"lane_line_{colour}_{mm}": (colour, mm) for colour in _COLOURS for mm in LINE_LENGTHS_MM}
"""Catalog name -> colour and length (mm)."""


def lane_line(name: str) -> ObjectModel:
    """Build a straight line along x ("lane_line_yellow_3000")."""
    colour, mm = LINES[name]
    size = (mm / 1000, LINE_WIDTH, PAINT)
    obj_id = 134 + LINE_LENGTHS_MM.index(mm)
    return model_of(name, "marking", obj_id, size, [box_part(size, (0.0, 0.0, 0.0), f"marking_{colour}")], (), turns=2)


def corner_marking(name: str = "corner_marking") -> ObjectModel:
    """Build the white angle that shows where a corner of a block-stacked pallet goes; its legs run to +x and +y."""
    leg, width = 0.3, LINE_WIDTH / 2
    parts = [
        box_part((leg, width, PAINT), (0.0, (width - leg) / 2, 0.0), "marking_white"),
        box_part((width, leg - width, PAINT), ((width - leg) / 2, width / 2, 0.0), "marking_white"),
    ]
    return model_of(name, "marking", 137, (leg, leg, PAINT), fused(parts), ())


def keep_clear_marking(name: str = "keep_clear_marking") -> ObjectModel:
    """Build the hatched yellow field that is kept free before doors and switchboards, 2.4 x 1.2 m."""
    length, width, line = 2.4, 1.2, LINE_WIDTH
    parts = [box_part((length, line, PAINT), (0.0, s * (width - line) / 2, 0.0), "marking_yellow") for s in (-1, 1)]
    inner = width - 2 * line
    parts += [box_part((line, inner, PAINT), (s * (length - line) / 2, 0.0, 0.0), "marking_yellow") for s in (-1, 1)]
    # Bars at 45 degrees; half a bar's width is kept from the frame so that corners stay inside.
    reach = inner * np.sqrt(2.0) - line
    for x in np.linspace(-0.6, 0.6, 5):
        parts.append(box_part((reach, line, PAINT), (x, 0.0, 0.0), "marking_yellow", rotation_z(np.pi / 4)))
    return model_of(name, "marking", 138, (length, width, PAINT), fused(parts), (), turns=2)


def crossing_marking(name: str = "crossing_marking") -> ObjectModel:
    """Build a pedestrian crossing: six white bars of 0.4 x 1.6 m with equal gaps, crossed along x."""
    bar, count, depth = 0.4, 6, 1.6
    length = (2 * count - 1) * bar
    starts = [-length / 2 + bar / 2 + 2 * bar * index for index in range(count)]
    parts = [box_part((bar, depth, PAINT), (x, 0.0, 0.0), "marking_white") for x in starts]
    return model_of(name, "marking", 139, (length, depth, PAINT), fused(parts), (), turns=2)


def tyre_mark_straight(name: str = "tyre_mark_straight") -> ObjectModel:
    """Build the two tracks of a truck that braked along x, 3.2 m long, thinning out at both ends."""
    x = np.linspace(-1.6, 1.6, 17)
    tracks = []
    for side, start in ((-1.0, 0), (1.0, 2)):
        line = np.column_stack([x[start:], np.full(17 - start, side * TYRE_TRACK / 2)])
        tracks.append(_ribbon(line))
    return _tyre_mark(name, 140, tracks)


def tyre_mark_curve(name: str = "tyre_mark_curve") -> ObjectModel:
    """Build the two tracks of a truck that turned a quarter round: outer radius 2.4 m."""
    angle = np.linspace(0.0, np.pi / 2, 25)
    tracks = [
        _ribbon(radius * np.column_stack([np.sin(angle[first:]), 1.0 - np.cos(angle[first:])]) + [0.0, 2.4 - radius])
        for radius, first in ((2.4, 0), (2.4 - TYRE_TRACK, 4))
    ]
    return _tyre_mark(name, 141, tracks)


def _tyre_mark(name: str, obj_id: int, tracks: list[TriangleMesh]) -> ObjectModel:
    points = np.concatenate([track.vertices for track in tracks])
    low, high = points.min(axis=0), points.max(axis=0)
    parts: list[Part] = [mesh_part(track, "tyre_mark", -(low + high) / 2) for track in tracks]
    x, y, z = high - low
    return model_of(name, "marking", obj_id, (float(x), float(y), float(z)), fused(parts), ())


def _ribbon(line: Float[np.ndarray, "n 2"]) -> TriangleMesh:
    """Return a flat band along ``line`` (m), a tyre wide in its middle and a fifth of it at its ends."""
    along = np.gradient(line, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    fraction = np.minimum(1.0, 0.2 + 3.2 * np.minimum(np.linspace(0, 1, len(line)), np.linspace(1, 0, len(line))))
    left = np.column_stack([-along[:, 1], along[:, 0]]) * (fraction * _MARK_WIDTH / 2)[:, None]
    count = len(line)
    rings = np.stack([line - left, line + left, line + left, line - left], axis=1)
    z = np.broadcast_to([-_TYRETHICK / 2, -_TYRETHICK / 2, _TYRETHICK / 2, _TYRETHICK / 2], (count, 4))
    vertices = np.concatenate([rings, z[:, :, None]], axis=2).reshape(-1, 3)
    faces = []
    for k in range(count - 1):
        for side in range(4):
            a, b = 4 * k + side, 4 * k + (side + 1) % 4
            faces += [(a, b, b + 4), (a, b + 4, a + 4)]
    last = 4 * (count - 1)
    faces += [(0, 2, 1), (0, 3, 2), (last, last + 1, last + 2), (last, last + 2, last + 3)]
    return TriangleMesh(vertices, np.array(faces, dtype=np.int32))


StainKind = Literal["stain", "patch", "water"]
STAINS: tuple[StainKind, ...] = ("stain", "patch", "water")
_AROUND = 90
"""Corners of the outline of a stain."""
_RAGGED = (7, 9, 12, 17, 23, 31)
"""Waves around it that make it ragged."""
VARIANTS = 12
"""Different tracks and stains of each kind; few, so that their meshes are made once."""
_TRACK = 0.95  # between the middles of a truck's front tyres (m)
_TYRE = (0.09, 0.17)  # width of the band that a tyre leaves (m)
_RADII = (2.2, 4.5)  # of turns into a place beside the aisle (m)
_SEEN = 0.6  # fraction of the passes whose rubber is still there
_SWAY = 0.035  # standard deviation of a pass about its lane, over the area's width
_SOFT = ((1.0, 0.0), (0.68, 0.5), (0.36, 1.2))
"""A tyre's band is bands in each other, which add up: widths over its own, and how much shorter each is at both ends
(m)."""
_SHORTEST = 0.6
"""Fraction of its length that is left of a short band at least."""


@cache
def tyre_tracks(length: float, width: float, passes: int, variant: int) -> ObjectModel:
    """Build the tracks of ``passes`` trucks along an aisle of ``length`` x ``width`` m, some of which turn off.

    Dust and litter lie between them and at the sides.
    """
    rng = np.random.default_rng([430, variant])
    faint: list[TriangleMesh] = []
    dark: list[TriangleMesh] = []
    # Drivers keep to their habits: two or three lanes beside each other.
    lanes = rng.uniform(-0.06, 0.06) * width + 0.17 * width * (np.arange(2 + variant % 2) - (1 + variant % 2) / 2)
    for number in range(max(round(_SEEN * passes), 1)):
        lane = lanes[rng.integers(len(lanes))] + rng.normal(0.0, _SWAY * width)
        y = float(np.clip(lane, -0.5 * width + 0.8, 0.5 * width - 0.8))
        start, end = np.sort(rng.uniform(-length / 2, length / 2, 2)) if number % 3 else (-length / 2, length / 2)
        line = _straight(float(start), float(end), y, rng)
        for side in (-1.0, 1.0):
            faint += _soft_band(_beside(line, side * _TRACK / 2), rng.uniform(*_TYRE))
        if number % 2:
            turn = _turn(float(rng.uniform(-0.4, 0.4) * max(length - 6.0, 0.0)), y, width, rng)
            for side in (-1.0, 1.0):
                faint += _soft_band(_beside(turn, side * _TRACK / 2), rng.uniform(*_TYRE))
            # Where it brakes and turns the outer tyre rubs off.
            dark += _soft_band(_beside(turn, -_TRACK / 2)[4:14], 0.09)
    parts = [_flat(band, "tyre_faint") for band in faint] + [_flat(band, "tyre_dark") for band in dark]
    # What lies about stays in the box of the tracks, so that this has the size of tracks alone.
    points = np.concatenate([part.mesh.vertices[:, :2] for part in parts])
    bounds = points.min(axis=0), points.max(axis=0)
    litter = floor_litter(length, width, *bounds, np.random.default_rng([434, variant]))
    parts += [_flat(mesh, material) for material, mesh in litter.items()]
    name = f"tyre_tracks_{round(1000 * length)}x{round(1000 * width)}_{passes}_{variant}"
    return _decal(name, 430, parts)


@cache
def floor_stain(kind: StainKind, variant: int) -> ObjectModel:
    """Build an oil stain, a repaired patch or a puddle, 0.3-2 m wide.

    Stains and water have ragged outlines and are darker inside; where a stain has dried its rim is the darkest.
    """
    rng = np.random.default_rng([431, STAINS.index(kind), variant])
    name = f"floor_{kind}_{variant}"
    if kind == "patch":
        x, y = rng.uniform(0.4, 1.6, 2) / 2
        corners = ((-x, -y), (x, -y), (x, y), (-x, y))
        return _decal(name, 432, [_flat(prism(corners, THICK), "floor_repair")])
    reach = 0.06 + 0.3 * rng.random() ** 2 if kind == "stain" else rng.uniform(0.3, 0.9)
    angle = np.arange(_AROUND) / _AROUND * 2 * np.pi
    wobble = sum(
        rng.uniform(0.05, 0.4) / order * np.cos(order * angle + rng.uniform(0, 2 * np.pi)) for order in (1, 2, 3, 5)
    )
    stretch, parts = rng.uniform(1.0, 1.9), []
    fractions, material = ((1.0, 0.88, 0.6), "floor_oil") if kind == "stain" else ((1.0, 0.93), "floor_water")
    for ring, fraction in enumerate(fractions):
        ragged = sum(
            rng.normal(0.0, 0.35 if kind == "stain" else 0.12)
            / order
            * np.cos(order * angle + rng.uniform(0, 2 * np.pi))
            for order in _RAGGED
        )
        radius = reach * fraction * np.maximum(1.0 + wobble + ragged, 0.15)
        outline = np.column_stack([stretch * radius * np.cos(angle), radius * np.sin(angle)])
        edge = tuple((float(x), float(y)) for x, y in outline)
        parts.append(_flat(prism(edge, THICK), material, ring * THICK))
        if kind == "stain" and ring == 0:
            dried = 0.97 * np.concatenate([outline, outline[:1]])
            rim = band(dried, float(np.clip(0.07 * reach, 0.008, 0.03)), narrowed=1.0)
            parts.append(_flat(rim, material, THICK / 2))
    return _decal(name, 431 if kind == "stain" else 433, parts)


def _straight(start: float, end: float, y: float, rng: np.random.Generator) -> Float[np.ndarray, "n 2"]:
    """Return a driver's line along x: straight but for a slow sway of a few centimetres."""
    x = np.linspace(start, end, max(int((end - start) / 1.2), 3))
    return np.column_stack([x, y + 0.05 * np.sin(x / rng.uniform(4.0, 9.0) + rng.uniform(0.0, 6.3))])


def _turn(x: float, y: float, width: float, rng: np.random.Generator) -> Float[np.ndarray, "n 2"]:
    """Return the line of a truck that turns from the aisle towards one of its sides."""
    radius, side, way = min(rng.uniform(*_RADII), 0.6 * width), rng.choice([-1.0, 1.0]), rng.choice([-1.0, 1.0])
    angle = np.linspace(0.0, rng.uniform(0.35, 0.5) * np.pi, 18)
    return np.column_stack([x + way * radius * np.sin(angle), y + side * radius * (1.0 - np.cos(angle))])


def _beside(line: Float[np.ndarray, "n 2"], offset: float) -> Float[np.ndarray, "n 2"]:
    """Return the line that runs ``offset`` m to the left of another."""
    along = np.gradient(line, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    return line + offset * np.column_stack([-along[:, 1], along[:, 0]])


def _soft_band(line: Float[np.ndarray, "n 2"], width: float) -> list[TriangleMesh]:
    """Return the bands in each other of a tyre of ``width`` m along a line: pale at their sides and ends."""
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    bands = []
    for fraction, shorter in _SOFT:
        inset = min(shorter, (1.0 - _SHORTEST) / 2 * way[-1])
        between = way[(way > inset) & (way < way[-1] - inset)]
        at = np.concatenate([[inset], between, [way[-1] - inset]])
        shortened = np.column_stack([np.interp(at, way, line[:, axis]) for axis in (0, 1)])
        bands.append(band(shortened, fraction * width))
    return bands


def _flat(mesh: TriangleMesh, material: str, lift: float = 0.0) -> Part:
    return mesh_part(mesh, material, (0.0, 0.0, lift))


def _decal(name: str, obj_id: int, parts: list[Part]) -> ObjectModel:
    """Return the model of flat ``parts`` about the middle of their box, one part a material."""
    whole = fused(parts)
    points = np.concatenate([part.mesh.vertices for part in whole])
    low, high = points.min(axis=0), points.max(axis=0)
    middle = (low + high) / 2
    centred = [mesh_part(part.mesh, part.material, -middle) for part in whole]
    x, y, z = (high - low).tolist()
    return model_of(name, "marking", obj_id, (x, y, z), centred, ())
