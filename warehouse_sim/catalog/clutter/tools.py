"""What is left standing or lying after work: a toolbox, a broom, a step ladder, a hand truck, a cable reel."""

import numpy as np

from warehouse_sim.catalog.parts import box_part, mesh_part, solid_box, solid_part
from warehouse_sim.catalog.traffic.shapes import assembled, rod, wheel
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform, rotation_x, rotation_y
from warehouse_sim.geometry.solids import unit_cylinder, unit_tube
from warehouse_sim.schema import ObjectModel


def toolbox(name: str = "toolbox") -> ObjectModel:
    """Build a steel toolbox, 0.5 m long, with a lid, a bar to carry it by and two latches."""
    parts = [
        box_part((0.50, 0.22, 0.15), (0.0, 0.0, 0.075), "steel_paint_blue"),
        box_part((0.51, 0.23, 0.06), (0.0, 0.0, 0.18), "steel_paint_blue"),
        *(box_part((0.02, 0.02, 0.05), (x, 0.0, 0.235), "steel_paint_black") for x in (-0.16, 0.16)),
        mesh_part(rod((-0.17, 0.0, 0.262), (0.17, 0.0, 0.262), 0.012), "steel_paint_black"),
        *(box_part((0.05, 0.006, 0.05), (x, 0.115, 0.145), "chrome") for x in (-0.14, 0.14)),
    ]
    solids = [solid_box((0.51, 0.236, 0.21), (0.0, 0.0, 0.105)), solid_box((0.34, 0.03, 0.07), (0.0, 0.0, 0.24))]
    return assembled(name, "clutter", 910, parts, solids, 9.0)


def broom(name: str = "broom") -> ObjectModel:
    """Build a hall broom that lies on the floor: a head of 0.6 m on its bristles' side and a stick of 1.4 m."""
    start, end = np.array([0.03, 0.0, 0.07]), np.array([1.42, 0.0, 0.013])
    parts = [
        box_part((0.05, 0.60, 0.045), (0.0, 0.0, 0.0925), "pallet_wood_tan"),
        box_part((0.07, 0.58, 0.07), (0.0, 0.0, 0.035), "plastic_red"),
        mesh_part(rod(start, end, 0.0125), "pallet_wood_new"),
    ]
    step = end - start
    turn = rotation_y(float(np.arctan2(-step[2], step[0])))
    stick = OrientedBox(make_transform(turn, (start + end) / 2), np.array([float(np.linalg.norm(step)), 0.025, 0.025]))
    return assembled(name, "clutter", 911, parts, [solid_box((0.07, 0.60, 0.115), (0.0, 0.0, 0.0575)), stick], 1.6)


def step_ladder(name: str = "step_ladder") -> ObjectModel:
    """Build a folding ladder of five treads that stands open, 1.3 m high."""
    height, spread, width = 1.3, 0.42, 0.46
    parts, solids = [], []
    for x, material in ((-1.0, "galvanised"), (1.0, "galvanised")):
        for y in (-1.0, 1.0):
            foot, top = np.array([x * spread, y * width / 2, 0.0]), np.array([x * 0.05, y * width * 0.42, height])
            turn = _towards(top - foot)
            size = np.array([0.05, 0.025, float(np.linalg.norm(top - foot)) - 0.03])
            middle = (foot + top) / 2 + np.array([0.0, 0.0, 0.005])
            parts.append(box_part(size, middle, material, turn))
            solids.append(OrientedBox(make_transform(turn, middle), size))
    for number in range(1, 6):
        fraction = number / 5.0
        x, z = -spread + fraction * (spread - 0.05), fraction * (height - 0.02)
        tread = (0.085 if number < 5 else 0.24, width * (1.0 - 0.16 * fraction) - 0.02, 0.03)
        at = (x if number < 5 else 0.0, 0.0, z)
        parts.append(box_part(tread, at, "plastic_red" if number == 5 else "galvanised"))
        solids.append(solid_box(tread, at))
    parts += [box_part((0.03, width, 0.03), (0.36 * spread / 0.42, 0.0, 0.25), "galvanised")]
    return assembled(name, "clutter", 912, parts, solids, 7.0)


def hand_truck(name: str = "hand_truck") -> ObjectModel:
    """Build a sack truck that stands on its toe plate and two wheels, 1.15 m high."""
    parts = [box_part((0.22, 0.40, 0.008), (0.11, 0.0, 0.004), "steel_paint_blue")]
    for side in (-1.0, 1.0):
        parts.append(mesh_part(rod((0.0, side * 0.19, 0.0), (-0.04, side * 0.19, 1.05), 0.014), "steel_paint_blue"))
        parts.append(mesh_part(rod((-0.04, side * 0.19, 1.05), (-0.16, side * 0.19, 1.15), 0.016), "rubber"))
        parts += wheel((-0.13, side * 0.25, 0.13), 0.26, 0.07, "plastic_red")
        parts.append(mesh_part(rod((-0.01, side * 0.19, 0.3), (-0.13, side * 0.19, 0.13), 0.01), "steel_paint_blue"))
    parts += [
        mesh_part(rod((-0.01 - 0.04 * z, -0.19, z), (-0.01 - 0.04 * z, 0.19, z), 0.011), "steel_paint_blue")
        for z in (0.3, 0.6, 0.9)
    ]
    parts.append(mesh_part(rod((-0.13, -0.25, 0.13), (-0.13, 0.25, 0.13), 0.01), "fork_steel"))
    solids = [
        solid_box((0.22, 0.40, 0.01), (0.11, 0.0, 0.005)),
        solid_box((0.26, 0.58, 0.26), (-0.13, 0.0, 0.13)),
        solid_box((0.07, 0.42, 1.05), (-0.02, 0.0, 0.525)),
        solid_box((0.15, 0.42, 0.13), (-0.1, 0.0, 1.09)),
    ]
    return assembled(name, "clutter", 913, parts, solids, 9.0)


def extension_reel(name: str = "extension_reel") -> ObjectModel:
    """Build a cable reel on a bent frame of tube, 0.36 m high."""
    across = rotation_x(np.pi / 2)
    parts = [
        solid_part(unit_tube(0.5, 24), (0.24, 0.24, 0.09), (0.0, 0.0, 0.19), "cone_orange", across),
        *(
            solid_part(unit_cylinder(24), (0.28, 0.28, 0.012), (0.0, y, 0.19), "plastic_black", across)
            for y in (-0.055, 0.055)
        ),
        *(
            mesh_part(rod((x, y, 0.01), (0.0, y, 0.345), 0.01, 8), "steel_paint_black")
            for x in (-0.13, 0.13)
            for y in (-0.08, 0.08)
        ),
        mesh_part(rod((0.0, -0.09, 0.345), (0.0, 0.09, 0.345), 0.014, 8), "plastic_black"),
        *(mesh_part(rod((x, -0.09, 0.01), (x, 0.09, 0.01), 0.01, 8), "steel_paint_black") for x in (-0.13, 0.13)),
    ]
    return assembled(name, "clutter", 914, parts, [solid_box((0.30, 0.19, 0.36), (0.0, 0.0, 0.18))], 6.0)


def _towards(way: np.ndarray) -> np.ndarray:
    """Return a rotation whose z axis runs along ``way``."""
    z = way / np.linalg.norm(way)
    y = np.cross(z, [1.0, 0.0, 0.0])
    y /= np.linalg.norm(y)
    return np.column_stack([np.cross(y, z), y, z])
