"""What both the reference and the fast model look at: walls by range, angle, material and light; edges."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tests.sensors.rgbd.depth.dots.boards import Board, Place
from tests.sensors.rgbd.depth.dots.infrared import Rig

RIGS = {"d435": Rig(424.0, 0.050), "d455": Rig(447.0, 0.095, projector_x=0.040)}
"""Focal lengths and baselines are those of the presets."""
KRAFT = {"remission": 0.30, "roughness": 0.85}
BLACK = {"remission": 0.06, "roughness": 0.45}
STEEL = {"remission": 0.90, "roughness": 0.5, "metallic": 0.5}


@dataclass(frozen=True)
class Case:
    """One measurement."""

    name: str
    """What is seen."""
    preset: str
    """By which camera."""
    place: Place
    """Boards and light."""
    edge: bool = False
    """Whether the first board stands before the second, and its edges are of interest."""


def cases() -> Iterator[Case]:
    """Yield all cases."""
    for preset, distances in (("d435", (0.6, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0)), ("d455", (1.0, 2.0, 4.0, 6.0, 8.0))):
        yield from (Case(f"white at {z:g} m", preset, Place([Board(z)])) for z in distances)
    for angle in (30.0, 45.0, 60.0, 70.0, 75.0, 80.0, 84.0):
        yield Case(f"white at 2 m, {angle:g} deg", "d435", Place([Board(2.0, angle)]))
        yield Case(f"kraft at 1.5 m, {angle:g} deg", "d455", Place([Board(1.5, angle, texture=0.08, **KRAFT)]))
    for name, material in (("kraft", KRAFT), ("black plastic", BLACK), ("galvanised", STEEL)):
        for z in (1.0, 2.0, 3.0, 4.0):
            yield Case(f"{name} at {z:g} m", "d435", Place([Board(z, 10.0, **material)]))
    for z in (2.0, 4.0, 6.0):
        yield Case(f"black plastic with texture at {z:g} m", "d435", Place([Board(z, 10.0, texture=0.3, **BLACK)]))
        yield Case(f"kraft with texture at {z:g} m", "d435", Place([Board(z, texture=0.2, grain=0.03, **KRAFT)]))
    for lux in (0.0, 100.0, 1000.0):
        yield Case(f"white at 4 m in {lux:g} lx", "d435", Place([Board(4.0)], lux))
    for preset in RIGS:
        for near, far in ((1.0, 1.5), (1.0, 3.0), (2.0, 4.0)):
            board = Board(near, x=0.05 * near, half_width=0.12 * near, **KRAFT)
            yield Case(f"board at {near:g} before {far:g} m", preset, Place([board, Board(far)]), True)


def held_out_cases() -> Iterator[Case]:
    """Yield cases at other ranges, angles, light and surfaces, which nothing was fitted to."""
    for z in (1.5, 2.5, 5.0, 7.0):
        yield Case(f"white at {z:g} m", "d435", Place([Board(z)]))
        yield Case(f"white at {z:g} m", "d455", Place([Board(z)]))
    for angle in (20.0, 52.0, 66.0, 73.0):
        yield Case(f"white at 2.7 m, {angle:g} deg", "d435", Place([Board(2.7, angle)]))
        yield Case(f"kraft at 2.2 m, {angle:g} deg", "d435", Place([Board(2.2, angle, texture=0.12, **KRAFT)]))
    for name, material in (("kraft", KRAFT), ("black plastic", BLACK), ("galvanised", STEEL)):
        yield Case(f"{name} at 2.6 m, 35 deg", "d455", Place([Board(2.6, 35.0, **material)], 600.0))
    yield Case("black plastic with texture at 3 m", "d455", Place([Board(3.0, 20.0, texture=0.2, **BLACK)], 150.0))
    for near, far in ((1.4, 2.0), (1.6, 5.0)):
        board = Board(near, x=0.05 * near, half_width=0.12 * near, **KRAFT)
        yield Case(f"board at {near:g} before {far:g} m", "d435", Place([board, Board(far)]), True)


def is_white(case: Case) -> bool:
    """Return whether a case is a white wall straight on."""
    only = case.place.boards[0]
    return len(case.place.boards) == 1 and only.remission == 1.0 and only.angle_deg == 0.0 and only.texture == 0.0


def middle(case: Case) -> tuple[slice, slice]:
    """Return the part of the image in which a wall is judged: of a turned one only about the axis."""
    width, height = RIGS[case.preset].size_wh
    half = 60 if is_white(case) else 14
    return np.s_[6 : height - 6, width // 2 + 10 - half : width // 2 + 10 + half]
