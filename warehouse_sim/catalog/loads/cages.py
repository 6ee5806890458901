"""Carriers welded of bars and wires, with the goods that lie in them: the Gitterbox and the roll container.

The EUR box pallet of UIC 435-3, in German "Gitterbox", is a steel frame on four feet with walls of mesh and a floor of
boards: outer 1,240 x 835 x 970 mm, inner 1,200 x 800 x 800 mm, tare 70 kg, payload 1,500 kg (EPAL); mesh of 50 x 50 mm;
the upper half of the front is two flaps. Corners reach over the frame, so that the feet of the next box stand inside.

The roll container of retail is a base on four castors between two side frames of tube and wire, filled with cartons.
724 x 810 mm is the footprint that two of fit across a EUR lorry three abreast (EN 12674 names the styles and leaves the
sizes free); 1,700 mm high, about 35 kg, loaded with up to 500 kg.
"""

from dataclasses import replace

import numpy as np

from warehouse_sim.catalog.loads.artwork import barcode, moved, on_side, rectangle, text_lines
from warehouse_sim.catalog.loads.cartons import carton
from warehouse_sim.catalog.parts import box_part, fused, model_of, solid_part
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.geometry.solids import unit_cylinder
from warehouse_sim.schema import ObjectModel, Part

Axis = int


def wire_panel(
    normal: Axis,
    at: float,
    across: tuple[float, float],
    up: tuple[float, float],
    pitch: tuple[float, float],
    wire: float,
    material: str,
) -> list[Part]:
    """Return a panel of upright and level wires, square in section, in a plane across x (0) or y (1).

    Args:
        normal: Axis that the panel is perpendicular to, 0 or 1.
        at: Place along it (m).
        across: First and last place along the other level axis (m).
        up: Lower and upper edge (m).
        pitch: Greatest distance of upright and of level wires (m).
        wire: Edge of a wire (m).
        material: Its material.
    """
    (left, right), (low, high) = across, up
    pieces = []
    for place in stations(left, right, pitch[0]):
        pieces.append(bar(normal, at, (place, (low + high) / 2), (wire, high - low), wire, material))
    for level in stations(low, high, pitch[1]):
        pieces.append(bar(normal, at, ((left + right) / 2, level), (right - left, wire), wire, material))
    return pieces


def bar(
    normal: Axis,
    at: float,
    centre: tuple[float, float],
    size: tuple[float, float],
    thick: float,
    material: str,
) -> Part:
    """Return a box in a plane across x or y: ``centre`` and ``size`` are along the other level axis and z (m)."""
    if normal == 0:
        return box_part((thick, size[0], size[1]), (at, *centre), material)
    return box_part((size[0], thick, size[1]), (centre[0], at, centre[1]), material)


def stations(first: float, last: float, pitch: float) -> list[float]:
    """Return evenly spaced places from ``first`` to ``last`` (m), at most ``pitch`` (m) apart."""
    return [float(place) for place in np.linspace(first, last, max(2, int(np.ceil((last - first) / pitch)) + 1))]


def ring(length: float, width: float, low: float, high: float, thick: float, material: str) -> list[Part]:
    """Return four bars around a rectangle, flush with its edges (m)."""
    middle, rise = (low + high) / 2, high - low
    long = [box_part((length, thick, rise), (0.0, s * (width - thick) / 2, middle), material) for s in (-1, 1)]
    inner = width - 2 * thick
    return [
        *long,
        *(box_part((thick, inner, rise), (s * (length - thick) / 2, 0.0, middle), material) for s in (-1, 1)),
    ]


_ARTICLES = ("carton_400x300x300", "carton_400x300x200", "carton_300x200x200")


def stacked_cartons(
    size: tuple[float, float, float], floor: float, seed: int, articles: tuple[str, ...] = _ARTICLES
) -> tuple[list[Part], float]:
    """Return cartons that fill a space to most of its height, with their mass (kg).

    Args:
        size: Edges of the space (m), centred on the z axis.
        floor: Height of its floor (m).
        seed: Of what lies where.
        articles: Cartons to take, one a layer.
    """
    rng = np.random.default_rng(seed)
    parts: list[Part] = []
    level, mass = 0.0, 0.0
    while True:
        model = carton(str(rng.choice(articles)))
        if level + model.size[2] > size[2]:
            return parts, mass
        ways = [[int(size[axis] / edges[axis]) for axis in (0, 1)] for edges in (model.size[:2], model.size[1::-1])]
        turned = int(np.prod(ways[1])) > int(np.prod(ways[0]))
        counts, edges = ways[turned], model.size[1::-1] if turned else model.size[:2]
        last = level + 2 * model.size[2] > size[2]
        for i in range(counts[0]):
            for j in range(counts[1]):
                if last and rng.random() < 0.35:
                    continue
                cell = np.array([size[0] / counts[0], size[1] / counts[1]])
                place = (np.array([i, j]) + 0.5) * cell - np.array(size[:2]) / 2
                place = place + rng.uniform(-0.8, 0.8, 2) * np.minimum((cell - edges) / 2, 0.012)
                yaw = (rng.integers(2) + turned / 2) * np.pi
                parts += _placed(model, (*place, floor + level + model.size[2] / 2), yaw)
                mass += model.mass
        level += float(model.size[2]) + 0.0005


def _placed(model: ObjectModel, centre: tuple[float, ...], yaw: float) -> list[Part]:
    T = make_transform(rotation_z(yaw), np.array(centre))
    return [replace(part, T_object_part=T @ part.T_object_part) for part in model.parts]


_BOX_LENGTH, _BOX_WIDTH, _BOX_HEIGHT = 1.240, 0.835, 0.970
"""Outer edges (m)."""
_BOX_TARE = 70.0
GITTERBOXES = {"gitterbox_empty": 301, "gitterbox_cartons": 302, "gitterbox_castings": 303}
"""Catalog name -> obj_id."""
_GREY = "steel_grey"
_FOOT, _FRAME_LOW, _FRAME_HIGH, _TOP = 0.10, 0.10, 0.155, 0.90
"""Heights of the feet, the lower frame and the upper frame's top (m)."""
_BOX_TUBE, _BOX_WIRE, _BOX_PITCH = 0.04, 0.006, 0.05
_CASTING, _CASTINGS = (0.17, 0.14, 0.11), (6, 4, 4)


def gitterbox(name: str) -> ObjectModel:
    """Build the box called ``name`` ("gitterbox_cartons")."""
    goods, mass = _contents(name)
    size = (_BOX_LENGTH, _BOX_WIDTH, _BOX_HEIGHT)
    return model_of(
        name,
        "gitterbox",
        GITTERBOXES[name],
        size,
        fused([*_frame(), *_walls(), *_plate(), *goods]),
        mass=_BOX_TARE + mass,
    )


def _frame() -> list[Part]:
    """Return feet, the two frames, posts, stacking corners and the floor."""
    low = -_BOX_HEIGHT / 2
    pieces = []
    for x in (-1, 1):
        for y in (-1, 1):
            foot = (x * (_BOX_LENGTH / 2 - 0.06), y * (_BOX_WIDTH / 2 - 0.05), low + _FOOT / 2)
            pieces.append(box_part((0.12, 0.10, _FOOT), foot, _GREY))
            post = (
                x * (_BOX_LENGTH / 2 - _BOX_TUBE / 2),
                y * (_BOX_WIDTH / 2 - _BOX_TUBE / 2),
                low + (_FRAME_LOW + _TOP) / 2,
            )
            pieces.append(box_part((_BOX_TUBE, _BOX_TUBE, _TOP - _FRAME_LOW), post, _GREY))
            rise, middle = _BOX_HEIGHT - _TOP, low + (_TOP + _BOX_HEIGHT) / 2
            pieces.append(
                box_part(
                    (0.12, 0.008, rise),
                    (x * (_BOX_LENGTH / 2 - 0.06), y * (_BOX_WIDTH / 2 - 0.004), middle),
                    _GREY,
                )
            )
            pieces.append(
                box_part(
                    (0.008, 0.10, rise),
                    (x * (_BOX_LENGTH / 2 - 0.004), y * (_BOX_WIDTH / 2 - 0.05), middle),
                    _GREY,
                )
            )
    pieces += ring(_BOX_LENGTH, _BOX_WIDTH, low + _FRAME_LOW, low + _FRAME_HIGH, _BOX_TUBE, _GREY)
    pieces += ring(_BOX_LENGTH, _BOX_WIDTH, low + _TOP - _BOX_TUBE, low + _TOP, _BOX_TUBE, _GREY)
    board = (_BOX_LENGTH - 2 * _BOX_TUBE, (_BOX_WIDTH - 2 * _BOX_TUBE) / 5 - 0.008, 0.02)
    for y in (np.arange(5) - 2) * (_BOX_WIDTH - 2 * _BOX_TUBE) / 5:
        pieces.append(box_part(board, (0.0, float(y), low + _FRAME_HIGH - 0.02), "pallet_wood_grey"))
    return pieces


def _walls() -> list[Part]:
    """Return mesh on all sides and the bars of the flaps on the front (-y)."""
    low, high = -_BOX_HEIGHT / 2 + _FRAME_HIGH, -_BOX_HEIGHT / 2 + _TOP - _BOX_TUBE
    long, short = _BOX_LENGTH / 2 - _BOX_TUBE, _BOX_WIDTH / 2 - _BOX_TUBE
    pieces = []
    for s in (-1, 1):
        pieces += wire_panel(
            1, s * (_BOX_WIDTH / 2 - 0.02), (-long, long), (low, high), (_BOX_PITCH, _BOX_PITCH), _BOX_WIRE, _GREY
        )
        pieces += wire_panel(
            0,
            s * (_BOX_LENGTH / 2 - 0.02),
            (-short, short),
            (low, high),
            (_BOX_PITCH, _BOX_PITCH),
            _BOX_WIRE,
            _GREY,
        )
    middle, front = (low + high) / 2, -_BOX_WIDTH / 2 + 0.0125
    pieces += [bar(1, front, (0.0, level), (2 * long, 0.03), 0.025, _GREY) for level in (middle - 0.02, middle + 0.02)]
    return [
        *pieces,
        *(
            bar(1, front, (s * 0.35 * _BOX_LENGTH, (middle + high) / 2), (0.03, high - middle), 0.025, _GREY)
            for s in (-1, 1)
        ),
    ]


def _plate() -> list[Part]:
    """Return the plate of the front with its marks, and a paper label below it."""
    size = (_BOX_LENGTH, _BOX_WIDTH, _BOX_HEIGHT)
    plate = on_side((rectangle(-0.16, 0.10, 0.16, 0.30),), "-y", size, "steel_grey", 0.001, 0.008)
    marks = moved(text_lines(0.26, 0.15, (0.9, 0.7, 0.8, 0.4)), 0.0, 0.2)
    paper = on_side((rectangle(-0.30, -0.22, -0.09, -0.07),), "-y", size, "label_paper", 0.001, 0.008)
    code = moved(barcode(301, 0.17, 0.06), -0.195, -0.16)
    return [
        *plate,
        *paper,
        *on_side(marks, "-y", size, "stencil_white", 0.0, 0.001),
        *on_side(
            (*code, *moved(text_lines(0.17, 0.05, (0.9, 0.6)), -0.195, -0.095)), "-y", size, "print_dark", 0.0, 0.001
        ),
    ]


def _contents(name: str) -> tuple[list[Part], float]:
    """Return what lies in the box and its mass (kg): nothing, cartons, or parts of cast steel."""
    floor = -_BOX_HEIGHT / 2 + _FRAME_HIGH - 0.01
    if name == "gitterbox_cartons":
        return stacked_cartons((1.14, 0.74, 0.70), floor + 0.002, GITTERBOXES[name])
    if name == "gitterbox_empty":
        return [], 0.0
    rng = np.random.default_rng(GITTERBOXES[name])
    pieces, (columns, rows, layers) = [], _CASTINGS
    for i in range(columns):
        for j in range(rows):
            for k in range(layers if rng.random() < 0.7 else layers - 1):
                centre = ((i - (columns - 1) / 2) * 0.185, (j - (rows - 1) / 2) * 0.18, floor + (k + 0.5) * 0.112)
                turn, size = rng.uniform(-0.12, 0.12), np.array(_CASTING) * rng.uniform(0.85, 1.0)
                c, s = np.cos(turn), np.sin(turn)
                pieces.append(box_part(size, centre, "truck_grey", np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])))
    return pieces, 7.0 * len(pieces)


_ROLL_LENGTH, _ROLL_WIDTH, _ROLL_HEIGHT = 0.810, 0.724, 1.700
"""Outer edges (m)."""
_ROLL_TARE = 35.0
ROLL_CONTAINERS = {
    "roll_container_empty": (311, 0.0),
    "roll_container_half": (312, 0.75),
    "roll_container_full": (313, 1.4),
    "roll_container_mixed": (314, 1.15),
}
"""Catalog name -> obj_id and the height up to which it is filled (m)."""
_ZINC, _ROLL_TUBE, _ROLL_WIRE = "galvanised", 0.026, 0.005
_WHEEL, _BASE = 0.125, 0.19
"""Diameter of a wheel and height of the base's top (m)."""


def roll_container(name: str) -> ObjectModel:
    """Build the container called ``name`` ("roll_container_full")."""
    obj_id, filled = ROLL_CONTAINERS[name]
    size = (_ROLL_LENGTH, _ROLL_WIDTH, _ROLL_HEIGHT)
    inner = (_ROLL_LENGTH - 0.10, _ROLL_WIDTH - 0.06, filled)
    goods, mass = stacked_cartons(inner, _BASE - _ROLL_HEIGHT / 2, obj_id)
    return model_of(name, "roll_container", obj_id, size, fused([*_base(), *_sides(), *goods]), mass=_ROLL_TARE + mass)


def _base() -> list[Part]:
    """Return the frame with its wires and four castors."""
    low = -_ROLL_HEIGHT / 2
    pieces = ring(_ROLL_LENGTH, _ROLL_WIDTH, low + _BASE - 0.03, low + _BASE, 0.03, _ZINC)
    for y in stations(-_ROLL_WIDTH / 2 + 0.05, _ROLL_WIDTH / 2 - 0.05, 0.06):
        pieces.append(box_part((_ROLL_LENGTH - 0.06, 0.006, 0.006), (0.0, y, low + _BASE - 0.005), _ZINC))
    lying = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
    for x in (-1, 1):
        for y in (-1, 1):
            place = np.array([x * (_ROLL_LENGTH / 2 - 0.10), y * (_ROLL_WIDTH / 2 - 0.08), low + _WHEEL / 2])
            pieces.append(solid_part(unit_cylinder(16), (_WHEEL, _WHEEL, 0.032), place, "rubber", lying))
            pieces.append(solid_part(unit_cylinder(12), (0.07, 0.07, 0.036), place, "plastic_grey", lying))
            pieces.append(box_part((0.07, 0.05, 0.012), place + np.array([0.0, 0.0, _WHEEL / 2 + 0.012]), _ZINC))
            for s in (-1, 1):
                pieces.append(box_part((0.035, 0.005, 0.10), place + np.array([0.0, s * 0.022, 0.03]), _ZINC))
    return pieces


def _sides() -> list[Part]:
    """Return the two side frames (across x), the back (+y) of a few wires and a strap before the front."""
    low, high = _BASE - _ROLL_HEIGHT / 2, _ROLL_HEIGHT / 2
    pieces = []
    for s in (-1, 1):
        x, half = s * (_ROLL_LENGTH / 2 - _ROLL_TUBE / 2), _ROLL_WIDTH / 2 - _ROLL_TUBE / 2
        pieces += [bar(0, x, (y, (low + high) / 2), (_ROLL_TUBE, high - low), _ROLL_TUBE, _ZINC) for y in (-half, half)]
        pieces += [
            bar(0, x, (0.0, z), (_ROLL_WIDTH, _ROLL_TUBE), _ROLL_TUBE, _ZINC)
            for z in (high - _ROLL_TUBE / 2, low + _ROLL_TUBE / 2)
        ]
        pieces += wire_panel(
            0, x, (-half + 0.07, half - 0.07), (low, high - _ROLL_TUBE), (0.1, 0.28), _ROLL_WIRE, _ZINC
        )
        pieces.append(bar(0, x, (0.0, low + 0.62), (_ROLL_WIDTH, 0.014), 0.014, _ZINC))
    back = _ROLL_WIDTH / 2 - 0.01
    reach = _ROLL_LENGTH / 2 - _ROLL_TUBE
    pieces += wire_panel(1, back, (-reach, reach), (low + 0.1, high - 0.3), (0.12, 0.30), _ROLL_WIRE, _ZINC)
    front = box_part((_ROLL_LENGTH - 2 * _ROLL_TUBE, 0.004, 0.03), (0.0, -_ROLL_WIDTH / 2 + 0.012, low + 0.70), "strap")
    return [*pieces, front]
