"""Big bags (flexible intermediate bulk containers, ISO 21898): woven bags of 500-1,000 kg with four loops to lift them.

Filled ones bulge: the walls are round and the foot keeps to its pallet; 1 m^3 of bulk goods of 0.5-1 t/m^3.
"""

from dataclasses import dataclass

import numpy as np

from warehouse_sim.catalog.parts import box_part, lofted, mesh_part, model_of, solid_box
from warehouse_sim.geometry.mesh import TriangleMesh, merge
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.geometry.solids import prism
from warehouse_sim.schema import ObjectModel, Part

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
