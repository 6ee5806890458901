"""What is painted on the floor or left there by tyres: flat objects without collision, their underside on the floor.

Lines of at least 50 mm mark traffic routes (ASR A1.3, 5.3); 100 mm is common. A line is sampled 1 mm thick, within the
1.5-3 mm of thermoplastic marking; a tyre mark, which has no thickness, as 0.4 mm so that it shows from afar.
"""

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog.parts import box_part, fused, mesh_part, model_of
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import rotation_z
from warehouse_sim.schema import ObjectModel, Part

LINE_WIDTH = 0.1
"""Width of a floor line (m)."""
LINE_LENGTHS_MM = (1000, 3000, 6000)
"""Lengths of the lines in the catalog."""
PAINT = 0.001
"""Thickness of paint (m)."""
TYRE_TRACK = 0.9
"""Distance between the two tracks of a counterbalance truck's front wheels (m)."""

_TYRE_WIDTH, _TYRE_FILM = 0.14, 0.0004
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
    left = np.column_stack([-along[:, 1], along[:, 0]]) * (fraction * _TYRE_WIDTH / 2)[:, None]
    count = len(line)
    rings = np.stack([line - left, line + left, line + left, line - left], axis=1)
    z = np.broadcast_to([-_TYRE_FILM / 2, -_TYRE_FILM / 2, _TYRE_FILM / 2, _TYRE_FILM / 2], (count, 4))
    vertices = np.concatenate([rings, z[:, :, None]], axis=2).reshape(-1, 3)
    faces = []
    for k in range(count - 1):
        for side in range(4):
            a, b = 4 * k + side, 4 * k + (side + 1) % 4
            faces += [(a, b, b + 4), (a, b + 4, a + 4)]
    last = 4 * (count - 1)
    faces += [(0, 2, 1), (0, 3, 2), (last, last + 1, last + 2), (last, last + 2, last + 3)]
    return TriangleMesh(vertices, np.array(faces, dtype=np.int32))
