"""What is seen through a hall's openings: a yard, what stands at its far side, and a sky over all of it.

Frame: origin at the centre of the bounding box, ``RISE`` m over the hall's floor; z up. The yard lies 1.2 m below that
floor, as before loading docks. It is one object of the class ``outdoors``, without collision: nothing in the hall
comes near it.
"""

from dataclasses import replace
from functools import cache

import numpy as np

from warehouse_sim.catalog.materials import SKY_BANDS
from warehouse_sim.catalog.parts import box_part, fused, mesh_part, model_of, solid_part
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.geometry.solids import unit_cylinder
from warehouse_sim.schema import ObjectModel, Part

OUTDOORS = "outdoors"
"""The class of what is outside the hall; a ray that meets it has left the hall."""
YARD_DROP = 1.2
"""Height of the hall's floor above the yard (m); 1.1-1.3 suit the beds of trailers."""
SKY_RADIUS = 240.0
"""Of the dome (m)."""
_BELOW = 4.8
"""How far the dome reaches below the hall's floor (m)."""
RISE = (SKY_RADIUS - _BELOW) / 2
"""Height of the object's centre above the hall's floor (m)."""
_DISTANCES = (
    26.0,
    46.0,
    75.0,
)  # from the hall's walls to parked trailers, to a belt of grass, to what stands behind it
_SIDES = 48


@cache
def outdoors(name: str = "outdoors", length: float = 48.0, width: float = 48.0) -> ObjectModel:
    """Build the surroundings of a hall of ``length`` x ``width`` m."""
    ground = -YARD_DROP
    parts = [_dome(band) for band in range(SKY_BANDS)]
    size = 2 * SKY_RADIUS
    parts.append(solid_part(unit_cylinder(_SIDES), (size, size, 0.4), (0.0, 0.0, ground - 0.2), "outdoor_grass"))
    paved = (length + 2 * _DISTANCES[1], width + 2 * _DISTANCES[1], 0.02)
    parts.append(box_part(paved, (0.0, 0.0, ground + 0.01), "outdoor_asphalt"))
    foundation = (length + 0.36, width + 0.36, YARD_DROP - 0.21)
    parts.append(box_part(foundation, (0.0, 0.0, ground / 2 - 0.105), "outdoor_facade"))
    pieces: list[Part] = []
    for turn in range(4):
        reach = (length if turn % 2 else width) / 2
        pieces += _side(turn, reach, (width if turn % 2 else length) + 80.0, ground + 0.02)
    lift = make_transform(translation=np.array([0.0, 0.0, -RISE]))
    placed = [replace(part, T_object_part=lift @ part.T_object_part) for part in (*parts, *fused(pieces))]
    return model_of(name, OUTDOORS, 405, (size, size, 2 * (SKY_RADIUS - RISE)), placed, ())


def _side(turn: int, reach: float, along: float, ground: float) -> list[Part]:
    """Return what stands before one wall: bays with trailers, lamps, halls and trees; the same each time."""
    rng = np.random.default_rng([405, turn])
    pieces = []

    def put(size: tuple[float, float, float], x: float, away: float, z: float, material: str) -> None:
        """Add a box whose near side is ``away`` m from the wall and whose foot is ``z`` m above the yard."""
        at = np.array([x, reach + away + size[1] / 2, ground + z + size[2] / 2])
        quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
        rotation = np.linalg.matrix_power(quarter, turn)
        pieces.append(box_part(size, rotation @ at, material, rotation))

    for x in np.arange(-along / 2, along / 2, 4.2):
        put((0.15, 14.0, 0.004), x, _DISTANCES[0], 0.0, "outdoor_line")
        if rng.random() < 0.45:
            put((2.55, 13.6, 2.75), x + 2.1, _DISTANCES[0] + 0.2, 1.15, "outdoor_trailer")
            put((2.3, 9.0, 1.1), x + 2.1, _DISTANCES[0] + 3.0, 0.05, "outdoor_facade_dark")
    for x in np.arange(-along / 2, along / 2, 28.0):
        put((0.16, 0.16, 9.0), x, _DISTANCES[1] - 4.0, 0.0, "outdoor_facade_dark")
        put((0.9, 0.5, 0.15), x, _DISTANCES[1] - 4.4, 8.9, "outdoor_lamp")
    x = -along / 2 - 30.0
    while x < along / 2 + 30.0:
        if rng.random() < 0.35:
            long, tall = rng.uniform(18.0, 45.0), rng.uniform(7.0, 13.0)
            put((long, 12.0, tall), x + long / 2, _DISTANCES[2] + rng.uniform(0, 10), 0.0, "outdoor_facade")
            put((long * 0.96, 0.1, 1.2), x + long / 2, _DISTANCES[2] - 0.12, tall * 0.6, "outdoor_facade_dark")
            x += long + rng.uniform(3.0, 10.0)
        else:
            wide, tall = rng.uniform(2.5, 6.0), rng.uniform(4.0, 10.0)
            put((wide, wide, tall), x, _DISTANCES[2] - rng.uniform(0.0, 14.0), 0.0, "outdoor_tree")
            x += wide * rng.uniform(0.5, 1.1)
    return pieces


def _dome(band: int) -> Part:
    """Return one ring of the sky, faces inward."""
    low, high = (np.pi / 2 * (fraction / SKY_BANDS) ** 1.6 for fraction in (band, band + 1))
    around = np.arange(_SIDES) / _SIDES * 2 * np.pi
    rings = [
        np.column_stack([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.full(_SIDES, np.sin(up))])
        for up in (low if band else -_BELOW / SKY_RADIUS, high)
    ]
    here = np.arange(_SIDES)
    there = (here + 1) % _SIDES
    faces = [np.column_stack([here, here + _SIDES, there])]
    if band < SKY_BANDS - 1:
        faces.append(np.column_stack([there, here + _SIDES, there + _SIDES]))
    vertices = SKY_RADIUS * np.concatenate(rings)
    if band == SKY_BANDS - 1:
        vertices, faces = vertices[: _SIDES + 1], [np.column_stack([here, np.full(_SIDES, _SIDES), there])]
    mesh = TriangleMesh(vertices, np.concatenate(faces).astype(np.int32))
    return mesh_part(mesh, f"outdoor_sky_{band}")
