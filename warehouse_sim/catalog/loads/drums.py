"""Drums of steel and plastic, full of liquid or powder; the axis is z.

The tight-head steel drum of 216.5 l follows ISO 15750-2 and EN 210: two rolling hoops, plugs G2 and G3/4 opposite
each other in the top; 585 mm across and 878 mm high are usual, with 1 mm steel it weighs about 18 kg. The L-ring drum
of 220 l weighs 9.5 kg (maplas.asia, "220L HDPE drums"); its 581 x 935 mm, like the size of the open-top drum of 60 l
with lid and lever ring, is common and unverified.
"""

from dataclasses import dataclass

import numpy as np

from warehouse_sim.catalog.loads.artwork import barcode, moved, text_lines
from warehouse_sim.catalog.parts import fused, mesh_part, model_of, solid_box
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.geometry.solids import Outline, lathe, prism, unit_cylinder
from warehouse_sim.schema import ObjectModel, Part

_SEGMENTS = 40


@dataclass(frozen=True)
class DrumSku:
    """One geometry of drum."""

    obj_id: int
    """Number of the geometry, fixed for ever."""
    diameter: float
    """Largest outer diameter (m)."""
    height: float
    """Height over all (m)."""
    mass: float
    """Kilograms, filled: tare and capacity times the density of the goods."""
    profile: Outline
    """Half section of the body from its lower to its upper pole, as (radius, height above the ground) in m."""
    head: float
    """Height of the top on which the plugs sit (m)."""
    plugs: tuple[tuple[float, float], ...]
    """Diameter (m) and place along x (m) of each plug."""
    label: tuple[float, float, float]
    """Radius of the body behind the label, lower and upper height of the label (m)."""


def _steel_profile() -> Outline:
    """Return chimes at both ends, a flat head 15 mm below the rim, hoops at a third and two thirds of the height."""
    body, chime, hoop, height = 0.2860, 0.2905, 0.2925, 0.878
    hoops = [
        (radius, level + dz)
        for level in (0.31, 0.57)
        for radius, dz in ((body, -0.022), (hoop, -0.008), (hoop, 0.008), (body, 0.022))
    ]
    lower = [(0.0, 0.012), (0.277, 0.012), (0.280, 0.0), (chime, 0.0), (chime, 0.014), (body, 0.022)]
    upper = [(body, height - 0.022), (chime, height - 0.014), (chime, height), (0.280, height), (0.277, height - 0.015)]
    return (*lower, *hoops, *upper, (0.0, height - 0.015))


def _l_ring_profile() -> Outline:
    """Return a round-shouldered body with an L-shaped ring to lift it at each end."""
    body, ring, height = 0.2830, 0.2905, 0.935
    lower = [(0.0, 0.010), (0.20, 0.010), (0.21, 0.0), (0.262, 0.0), (0.276, 0.03), (0.279, 0.055)]
    low_ring = [(ring, 0.058), (ring, 0.082), (0.280, 0.086), (body, 0.13)]
    top_ring = [(body, height - 0.13), (0.280, height - 0.086), (ring, height - 0.082), (ring, height - 0.050)]
    shoulder = [(0.279, height - 0.046), (0.272, height - 0.022), (0.250, height - 0.004), (0.235, height)]
    return (*lower, *low_ring, *top_ring, *shoulder, (0.21, height), (0.20, height - 0.018), (0.0, height - 0.018))


def _open_top_profile() -> Outline:
    """Return a slightly tapered body up to the lever ring; the lid is a part of its own."""
    height = 0.605
    return (
        (0.0, 0.008), (0.15, 0.008), (0.16, 0.0), (0.178, 0.0), (0.186, 0.02), (0.1955, height - 0.16),
        (0.1955, height - 0.07), (0.188, height - 0.06), (0.188, height - 0.02), (0.0, height - 0.02),
    )  # fmt: skip


_STEEL = DrumSku(34, 0.585, 0.878, 18.0 + 0.2165 * 900.0, _steel_profile(), 0.863, ((0.07, 0.2), (0.04, -0.215)),
                 (0.2860, 0.34, 0.54))  # fmt: skip
_L_RING = DrumSku(35, 0.581, 0.935, 9.5 + 0.220 * 1000.0, _l_ring_profile(), 0.917, ((0.08, 0.14), (0.08, -0.14)),
                  (0.2830, 0.40, 0.62))  # fmt: skip
_OPEN_TOP = DrumSku(36, 0.400, 0.605, 3.0 + 0.060 * 700.0, _open_top_profile(), 0.605, (), (0.1915, 0.22, 0.36))
DRUMS = {
    "drum_steel_216_blue": (_STEEL, "steel_paint_blue"),
    "drum_steel_216_black": (_STEEL, "steel_paint_black"),
    "drum_plastic_220_blue": (_L_RING, "plastic_blue"),
    "drum_plastic_220_black": (_L_RING, "plastic_black"),
    "drum_plastic_60_blue": (_OPEN_TOP, "plastic_blue"),
    "drum_plastic_60_white": (_OPEN_TOP, "plastic_white"),
}
"""Catalog name -> geometry and material of the body; the colours of one drum are one geometry."""


def drum(name: str) -> ObjectModel:
    """Build the drum called ``name`` ("drum_steel_216_blue")."""
    sku, material = DRUMS[name]
    body = tuple((radius, height - sku.height / 2) for radius, height in sku.profile)
    parts = [mesh_part(lathe(body, _SEGMENTS), material)]
    parts += _lid(sku) if sku is _OPEN_TOP else _plugs(sku)
    return model_of(
        name,
        "drum",
        sku.obj_id,
        (sku.diameter, sku.diameter, sku.height),
        (*parts, *fused(_label(sku))),
        round_body(sku.diameter, sku.height),
        mass=sku.mass,
    )


def round_body(diameter: float, height: float) -> tuple[OrientedBox, ...]:
    """Return four boxes turned by 45 degrees each, whose corners are a regular octagon inside the circle (m)."""
    long, short = diameter * np.cos(np.pi / 8), diameter * np.sin(np.pi / 8)
    size = solid_box((long, short, height)).size
    return tuple(OrientedBox(make_transform(rotation_z(turn)), size) for turn in np.arange(4) * np.pi / 4)


def _plugs(sku: DrumSku) -> list[Part]:
    material = "galvanised" if sku is _STEEL else "plastic_black"
    rise = 0.012
    return [
        Part(
            unit_cylinder(16),
            np.array([diameter, diameter, rise]),
            make_transform(translation=np.array([x, 0.0, sku.head - sku.height / 2 + rise / 2])),
            material,
        )
        for diameter, x in sku.plugs
    ]


def _lid(sku: DrumSku) -> list[Part]:
    """Return the lid with a raised rim, the ring of galvanised steel that clamps it, and the ring's lever."""
    radius, top, low = sku.diameter / 2, sku.height / 2, sku.height / 2 - 0.05
    lid: Outline = ((0.0, low + 0.03), (0.188, low + 0.03), (0.197, low + 0.03), (0.197, top), (0.176, top),
                    (0.170, top - 0.012), (0.0, top - 0.012))  # fmt: skip
    ring: Outline = ((0.187, low + 0.004), (radius, low + 0.004), (radius, low + 0.030), (0.187, low + 0.030))
    turns = np.linspace(-0.22, 0.22, 6)
    outer = [(radius * np.cos(a), radius * np.sin(a)) for a in turns]
    inner = [((radius - 0.008) * np.cos(a), (radius - 0.008) * np.sin(a)) for a in turns[::-1]]
    lever = mesh_part(prism((*outer, *inner), 0.018), "print_dark", (0.0, 0.0, low + 0.017))  # fmt: skip
    return [
        mesh_part(lathe(lid, _SEGMENTS), "plastic_black"),
        mesh_part(lathe(ring, _SEGMENTS), "galvanised"),
        lever,
    ]


def _label(sku: DrumSku) -> list[Part]:
    """Return a label bent around the body, with lines of text and a barcode."""
    radius, low, high = sku.label
    middle, tall = (low + high) / 2 - sku.height / 2, high - low
    wide = 1.1 * tall
    paper = _bent(radius + 0.0008, (-wide / 2, -tall / 2, wide / 2, tall / 2), middle, "label_paper")
    ink = (
        *moved(text_lines(0.8 * wide, 0.4 * tall, (0.9, 0.6, 0.75, 0.5)), 0.0, 0.2 * tall),
        *moved(barcode(sku.obj_id, 0.7 * wide, 0.25 * tall, 14), 0.0, -0.25 * tall),
    )
    return [paper, *(_bent(radius + 0.0016, (*shape[0], *shape[2]), middle, "print_dark") for shape in ink)]


def _bent(radius: float, edges: tuple[float, float, float, float], level: float, material: str) -> Part:
    """Return a slab bent around the z axis at +y; ``edges`` of the flat one are left, bottom, right, top (m)."""
    left, bottom, right, top = edges
    # Seen from outside, right is -x.
    angles = np.pi / 2 - np.linspace(-left, -right, max(2, int((right - left) / 0.03) + 2)) / radius
    outer = [(radius * float(np.cos(a)), radius * float(np.sin(a))) for a in angles]
    inner = [((radius - 0.006) * float(np.cos(a)), (radius - 0.006) * float(np.sin(a))) for a in angles[::-1]]
    centre = np.array([0.0, 0.0, level + (top + bottom) / 2])
    return mesh_part(prism((*outer, *inner), top - bottom), material, centre)
