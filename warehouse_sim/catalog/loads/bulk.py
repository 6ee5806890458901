"""Carriers of bulk goods: octabins and big bags of granules, IBCs of liquids.

Octabins are eight-sided boxes of heavy corrugated board with a lid, standing on a pallet alone. They hold 300-1,100 kg;
footprints follow the pallet, 1,160 x 960 mm on 1,200 x 1,000 and 1,160 x 760 mm on 1,200 x 800, heights 800-1,900 mm
(common in makers' lists, unverified). Plastic granules weigh 0.5-0.6 t/m^3 in bulk.

Big bags (flexible intermediate bulk containers, ISO 21898) are woven bags of 500-1,000 kg with four loops to lift them.
Filled ones bulge: the walls are round and the foot keeps to its pallet; 1 m^3 of bulk goods of 0.5-1 t/m^3.

A composite IBC of 1,000 l is a bottle of HDPE in a cage of galvanised tube, with lid, valve and plate; 1,200 x 1,000 x
1,160 mm over all with its pallet, of which the catalog's 1,200 x 1,000 ones are 144 mm; about 60 kg empty; a maker lets
three more of 1,264 kg stand on one (4,056 kg).
"""

from dataclasses import dataclass

import numpy as np

from warehouse_sim.catalog.loads import artwork
from warehouse_sim.catalog.loads.cages import bar, stations
from warehouse_sim.catalog.parts import box_part, fused, lofted, mesh_part, model_of, slab_part, solid_box, solid_part
from warehouse_sim.geometry.mesh import TriangleMesh, merge
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.geometry.solids import Outline, prism, unit_cylinder
from warehouse_sim.schema import ObjectModel, Part

_LID, _SKIN = 0.12, 0.004
"""Height of the lid's sides and how far they stand out (m)."""


@dataclass(frozen=True)
class OctabinSku:
    """One geometry of octabin."""

    obj_id: int
    length: float
    width: float
    height: float
    cut: float
    """How much the corners take of each edge (m)."""
    mass: float
    board: str
    brand: str


OCTABINS = {
    "octabin_1160x960x1200": OctabinSku(321, 1.16, 0.96, 1.20, 0.22, 640.0, "kraft", "POLENE"),
    "octabin_1160x960x950": OctabinSku(322, 1.16, 0.96, 0.95, 0.22, 500.0, "kraft_light", "NATUPEL"),
    "octabin_1160x760x1050": OctabinSku(323, 1.16, 0.76, 1.05, 0.18, 430.0, "kraft_dark", "LUPOL"),
    "octabin_1160x760x1350": OctabinSku(324, 1.16, 0.76, 1.35, 0.18, 560.0, "kraft", "CELOPAN"),
}
"""Catalog name -> geometry."""


def octabin(name: str) -> ObjectModel:
    """Build the octabin called ``name`` ("octabin_1160x960x1200")."""
    sku = OCTABINS[name]
    body = _octagon(sku.length - 2 * _SKIN, sku.width - 2 * _SKIN, sku.cut)
    lid = _octagon(sku.length, sku.width, sku.cut)
    parts = [
        slab_part(body, -sku.height / 2, sku.height / 2 - 0.003, sku.board),
        slab_part(lid, sku.height / 2 - _LID, sku.height / 2, "kraft_light" if sku.board == "kraft" else "kraft"),
        *(
            slab_part(_octagon(sku.length - 0.004, sku.width - 0.004, sku.cut), z, z + 0.016, "strap")
            for z in _bands(sku)
        ),
    ]
    cut = sku.cut
    return model_of(
        name,
        "octabin",
        sku.obj_id,
        (sku.length, sku.width, sku.height),
        fused([*parts, *_print(sku)]),
        (
            solid_box((sku.length, sku.width - 2 * cut, sku.height)),
            solid_box((sku.length - 2 * cut, sku.width, sku.height)),
        ),
        mass=sku.mass,
    )


def _octagon(length: float, width: float, cut: float) -> Outline:
    x, y = length / 2, width / 2
    return ((x - cut, -y), (x, cut - y), (x, y - cut), (x - cut, y), (cut - x, y), (-x, y - cut), (-x, cut - y),
            (cut - x, -y))  # fmt: skip


def _bands(sku: OctabinSku) -> list[float]:
    """Return the heights (m) of the bands that hold the bulging board."""
    return [-sku.height / 2 + fraction * sku.height for fraction in (0.18, 0.42, 0.66)]


def _print(sku: OctabinSku) -> list[Part]:
    """Return brand, marks and a label on the long sides, a label on one short side."""
    size = (sku.length, sku.width, sku.height)
    ink = [*artwork.moved(artwork.word(sku.brand, 0.11), 0.0, 0.10 * sku.height)]
    ink += artwork.moved(artwork.handling_mark("up", 0.12), -0.2, -0.12 * sku.height)
    ink += artwork.moved(artwork.handling_mark("dry", 0.12), -0.05, -0.12 * sku.height)
    pieces: list[Part] = []
    long_sides: tuple[artwork.Side, ...] = ("-y", "+y")
    for side in long_sides:
        pieces += artwork.on_side(tuple(ink), side, size, "print_blue", 0.002, 0.003)
    label = artwork.moved((artwork.rectangle(-0.105, -0.074, 0.105, 0.074),), 0.15, -0.13 * sku.height)
    lines = (
        *artwork.moved(artwork.text_lines(0.18, 0.05, (0.9, 0.6, 0.8)), 0.0, 0.04),
        *artwork.moved(artwork.barcode(sku.obj_id, 0.16, 0.05), 0.0, -0.03),
    )
    labelled: tuple[artwork.Side, ...] = ("-y", "+x")
    for side in labelled:
        pieces += artwork.on_side(label, side, size, "label_paper", 0.001, 0.004)
        pieces += artwork.on_side(artwork.moved(lines, 0.15, -0.13 * sku.height), side, size, "print_dark", 0.0, 0.002)
    return pieces


_AROUND, _LEVELS = 40, 22
_LOOP = 0.16
"""How far the loops reach over the bag (m)."""


@dataclass(frozen=True)
class BigBagSku:
    """One geometry of big bag."""

    obj_id: int
    """Number of the geometry and seed of its shape, fixed for ever."""
    length: float
    width: float
    height: float
    """Outer edges, loops included (m)."""
    mass: float
    material: str


BIG_BAGS = {
    "big_bag_1000x950x1200": BigBagSku(331, 1.00, 0.95, 1.20, 1000.0, "sack_woven"),
    "big_bag_980x960x1150": BigBagSku(332, 0.98, 0.96, 1.15, 900.0, "sack_woven"),
    "big_bag_1100x790x1100": BigBagSku(333, 1.10, 0.79, 1.10, 700.0, "plastic_white"),
    "big_bag_1060x780x1020": BigBagSku(334, 1.06, 0.78, 1.02, 600.0, "sack_woven"),
}
"""Catalog name -> geometry."""


def big_bag(name: str) -> ObjectModel:
    """Build the bag called ``name`` ("big_bag_1000x950x1200")."""
    sku = BIG_BAGS[name]
    size = np.array([sku.length, sku.width, sku.height])
    body = _body(sku)
    parts = [mesh_part(body, sku.material), *_loops(sku), *_pouch(sku)]
    solid = (0.92 * sku.length, 0.92 * sku.width, sku.height - _LOOP)
    return model_of(
        name, "big_bag", sku.obj_id, size, parts, (solid_box(solid, (0.0, 0.0, -_LOOP / 2)),), mass=sku.mass
    )


def _body(sku: BigBagSku) -> TriangleMesh:
    """Return the filled bag: rings of superellipses that swell with height, folds, a domed top and a tied spout."""
    rng = np.random.default_rng(sku.obj_id)
    low, tall = -sku.height / 2, sku.height - _LOOP
    angles = np.arange(_AROUND) * 2 * np.pi / _AROUND
    phases = rng.uniform(0.0, 2 * np.pi, 5)
    rings = []
    for fraction in np.linspace(0.0, 1.0, _LEVELS):
        swell = 0.86 + 0.14 * np.sin(np.pi * min(fraction / 0.84, 1.0)) ** 0.7
        # Over the shoulder the bag closes towards the spout.
        swell *= 1.0 if fraction < 0.84 else 1.0 - 0.62 * ((fraction - 0.84) / 0.16) ** 2.2
        power = 2.0 / (4.5 - 1.5 * np.sin(np.pi * fraction))
        cosine, sine = np.cos(angles), np.sin(angles)
        folds = sum(np.cos((k + 3) * angles + phases[k] + 2.5 * fraction) / (k + 2) for k in range(5))
        folds = 1.0 + (0.006 + 0.03 * abs(fraction - 0.45)) * np.asarray(folds)
        x = np.sign(cosine) * np.abs(cosine) ** power * folds * swell * sku.length / 2
        y = np.sign(sine) * np.abs(sine) ** power * folds * swell * sku.width / 2
        rings.append(np.column_stack([x, y, np.full(_AROUND, low + fraction * tall)]))
    points = np.array(rings)
    low_xy, high_xy = points[..., :2].min(axis=(0, 1)), points[..., :2].max(axis=(0, 1))
    points[..., :2] = (
        (points[..., :2] - (low_xy + high_xy) / 2) * np.array([sku.length, sku.width]) / (high_xy - low_xy)
    )
    return lofted(points)


def _loops(sku: BigBagSku) -> list[Part]:
    """Return four loops of webbing at the shoulders; each is an arch of a flat band."""
    high, rise = sku.height / 2, _LOOP + 0.14
    outer = [(0.11 * np.cos(a), rise * np.sin(a)) for a in np.linspace(0.0, np.pi, 11)]
    inner = [(0.085 * np.cos(a), (rise - 0.02) * np.sin(a)) for a in np.linspace(np.pi, 0.0, 11)]
    stand = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
    arch = prism(tuple((float(x), float(y)) for x, y in (*outer, *inner)), 0.05)
    meshes = []
    for number, (x, y) in enumerate(((-1, -1), (1, -1), (1, 1), (-1, 1))):
        turn = rotation_z(np.pi / 4 + number * np.pi / 2 + 0.15 * np.sin(sku.obj_id + number)) @ stand
        place = np.array([x * 0.30 * sku.length, y * 0.30 * sku.width, high - rise])
        T = make_transform(turn, place)
        meshes.append(TriangleMesh(arch.vertices @ T[:3, :3].T + T[:3, 3], arch.faces))
    return [mesh_part(merge(meshes), "strap" if sku.obj_id % 2 else "print_blue")]


def _pouch(sku: BigBagSku) -> list[Part]:
    """Return the document pouch with its paper, flat on the bulge of the front."""
    y = -sku.width / 2 + 0.0045
    return [box_part((0.22, 0.008, 0.30), (0.0, y, 0.02), "label_paper"),
            box_part((0.16, 0.008, 0.04), (0.0, y - 0.0005, 0.10), "print_dark")]  # fmt: skip


_IBC_LENGTH, _IBC_WIDTH, _IBC_HEIGHT = 1.200, 1.000, 1.016
"""Outer edges without the pallet (m)."""
IBCS = {"ibc_1000": (341, "plastic_white", 1040.0), "ibc_1000_black": (342, "plastic_black", 1040.0)}
"""Catalog name -> obj_id, material of the bottle, mass without the pallet (kg)."""
_IBC_TUBE, _ZINC = 0.018, "galvanised"


def ibc(name: str) -> ObjectModel:
    """Build the container called ``name`` ("ibc_1000")."""
    obj_id, material, mass = IBCS[name]
    size = (_IBC_LENGTH, _IBC_WIDTH, _IBC_HEIGHT)
    return model_of(name, "ibc", obj_id, size, fused([*_bottle(material), *_cage(), *_plates(obj_id)]), mass=mass)


def _bottle(material: str) -> list[Part]:
    """Return the bottle with a rounded outline and shoulder, the lid on top and the valve low on the front (-x)."""
    low, high = -_IBC_HEIGHT / 2 + 0.02, _IBC_HEIGHT / 2 - 0.045
    pieces = [
        slab_part(_rounded(1.14, 0.94, 0.12), low, high - 0.05, material),
        slab_part(_rounded(1.08, 0.88, 0.12), high - 0.05, high - 0.02, material),
        slab_part(_rounded(0.98, 0.78, 0.12), high - 0.02, high, material),
        solid_part(unit_cylinder(20), (0.20, 0.20, 0.03), (0.0, 0.0, high + 0.015), "plastic_black"),
        solid_part(unit_cylinder(20), (0.15, 0.15, 0.012), (0.0, 0.0, high + 0.036), "plastic_red"),
    ]
    lying = np.array([[0, 0, 1.0], [0, 1.0, 0], [-1.0, 0, 0]])
    valve = np.array([-_IBC_LENGTH / 2 + 0.055, 0.0, low + 0.06])
    pieces.append(solid_part(unit_cylinder(16), (0.09, 0.09, 0.10), valve, "plastic_black", lying))
    pieces.append(box_part((0.02, 0.03, 0.11), valve + np.array([-0.03, 0.0, 0.06]), "plastic_red"))
    return pieces


def _cage() -> list[Part]:
    """Return tubes around the bottle, a tray under it and two tubes over it."""
    low, high = -_IBC_HEIGHT / 2, _IBC_HEIGHT / 2
    half_x, half_y, tube = _IBC_LENGTH / 2 - _IBC_TUBE / 2, _IBC_WIDTH / 2 - _IBC_TUBE / 2, _IBC_TUBE
    pieces = [box_part((_IBC_LENGTH, _IBC_WIDTH, 0.012), (0.0, 0.0, low + 0.006), _ZINC)]
    for s in (-1, 1):
        for y in stations(-half_y, half_y, 0.125):
            # The valve stands in a gap of the front.
            start = 0.24 if s < 0 and abs(y) < 0.10 else 0.0
            pieces.append(bar(0, s * half_x, (y, (low + start + high) / 2), (tube, high - low - start), tube, _ZINC))
        for x in stations(-half_x, half_x, 0.13)[1:-1]:
            pieces.append(bar(1, s * half_y, (x, 0.0), (tube, high - low), tube, _ZINC))
        for z in (low + 0.10, low + 0.34, low + 0.58, low + 0.82, high - tube / 2):
            open_front = s < 0 and z < low + 0.2
            edges = ((-half_y, -0.1), (0.1, half_y)) if open_front else ((-half_y, half_y),)
            pieces += [bar(0, s * half_x, ((a + b) / 2, z), (b - a, tube), tube, _ZINC) for a, b in edges]
            pieces.append(bar(1, s * half_y, (0.0, z), (2 * half_x, tube), tube, _ZINC))
    for x in (-0.27, 0.27):
        pieces.append(box_part((tube, _IBC_WIDTH - tube, tube), (x, 0.0, high - tube / 2), _ZINC))
    return pieces


def _plates(obj_id: int) -> list[Part]:
    """Return a steel plate with a label on the front and on one long side."""
    size = (_IBC_LENGTH, _IBC_WIDTH, _IBC_HEIGHT)
    plate, paper = artwork.rectangle(-0.21, -0.02, 0.21, 0.30), artwork.rectangle(-0.15, 0.02, 0.15, 0.23)
    ink = (
        *artwork.moved(artwork.text_lines(0.26, 0.08, (0.9, 0.6, 0.75, 0.5)), 0.0, 0.18),
        *artwork.moved(artwork.barcode(obj_id, 0.22, 0.06), 0.0, 0.07),
    )
    pieces: list[Part] = []
    for side in ("-x", "-y"):
        pieces += artwork.on_side((plate,), side, size, _ZINC, 0.002, 0.004)
        pieces += artwork.on_side((paper,), side, size, "label_paper", 0.001, 0.003)
        pieces += artwork.on_side(ink, side, size, "print_dark", 0.0, 0.002)
    return pieces


def _rounded(length: float, width: float, radius: float) -> Outline:
    """Return a rectangle with round corners, counter-clockwise (m)."""
    turns = np.linspace(0.0, np.pi / 2, 6)
    corners = ((1, 1, 0.0), (-1, 1, np.pi / 2), (-1, -1, np.pi), (1, -1, 1.5 * np.pi))
    return tuple(
        (
            float(sx * (length / 2 - radius) + radius * np.cos(start + turn)),
            float(sy * (width / 2 - radius) + radius * np.sin(start + turn)),
        )
        for sx, sy, start in corners
        for turn in turns
    )
