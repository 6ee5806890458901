"""Filled sacks: a cushion with flat ends, wrinkled a little, lying on its broad side with its length along x.

A valve sack of paper with 25 kg of cement is about 600 x 400 x 110 mm: bulk cement is poured at 1.1-1.4 t/m^3 and fills
about 85 % of the box around the sack. A woven sack of 20 kg of plastic granules (0.55-0.75 t/m^3 bulk) is thicker.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog.parts import lofted, mesh_part, model_of
from warehouse_sim.geometry.mesh import TriangleMesh, merge
from warehouse_sim.schema import ObjectModel

_AROUND, _STATIONS = 32, 25
_PRINT = 0.0012
"""How far the print stands over the sack (m)."""


@dataclass(frozen=True)
class SackSku:
    """One geometry of sack."""

    obj_id: int
    """Number of the geometry and seed of its wrinkles, fixed for ever."""
    length: float
    """Outer edge along x (m)."""
    width: float
    """Outer edge along y (m)."""
    height: float
    """Outer edge along z (m)."""
    mass: float
    """Kilograms."""
    print_material: str
    """Material of the printed fields."""
    fields: tuple[tuple[int, int], ...]
    """First and last station of each printed field."""


_PAPER = SackSku(37, 0.60, 0.40, 0.11, 25.0, "print_blue", ((5, 6), (8, 17)))
_PAPER_B = SackSku(38, 0.60, 0.40, 0.12, 25.0, "print_red", ((4, 10), (12, 13), (15, 16)))
_WOVEN = SackSku(39, 0.59, 0.39, 0.14, 20.0, "print_green", ((7, 16), (18, 19)))
SACKS = {
    "sack_paper_600x400x110": (_PAPER, "sack_paper"),
    "sack_white_600x400x120": (_PAPER_B, "board_white"),
    "sack_woven_590x390x140": (_WOVEN, "sack_woven"),
}
"""Catalog name -> geometry and material: the first shape of each article."""
_FIRST_SHAPE, _SHAPES = 351, 5
"""Number of the first further shape, and how many each article has."""
_SLACK = 0.035
"""Greatest share by which a further shape is shorter or narrower than its article."""


def _shape(sku: SackSku, number: int) -> SackSku:
    """Return another filling of the same sack: its own wrinkles, a little shorter and narrower, as high."""
    rng = np.random.default_rng([number, sku.obj_id])
    length, width = (round(edge * (1.0 - rng.uniform(0.0, _SLACK)), 3) for edge in (sku.length, sku.width))
    return replace(sku, obj_id=number, length=length, width=width)


SACK_SHAPES = {
    f"{name}_{shape + 2}": (_shape(sku, _FIRST_SHAPE + _SHAPES * number + shape), material)
    for number, (name, (sku, material)) in enumerate(SACKS.items())
    for shape in range(_SHAPES)
}
"""Catalog name -> geometry and material of the further shapes: goods in sacks are never alike."""


def shapes_of(name: str) -> tuple[str, ...]:
    """Return the catalog names of all shapes of an article, the first included."""
    return (name, *(f"{name}_{shape + 2}" for shape in range(_SHAPES) if name in SACKS))


def sack(name: str, every: int = 1) -> ObjectModel:
    """Build the sack called ``name`` ("sack_paper_600x400x110").

    Args:
        name: Of its SKU.
        every: Keep each how manieth point of its outlines, along and around: 2 has a quarter of the triangles, for
            what stands far away.
    """
    known = SACKS | SACK_SHAPES
    sku, material = known[name]
    size = np.array([sku.length, sku.width, sku.height])
    rings = (_rings(sku.obj_id) if name in SACKS else _slumped(_rings(sku.obj_id), sku.obj_id)) * size / 2
    rings = rings[::every, ::every]
    # The print is a length of the body itself, lifted off it, so that it follows every wrinkle.
    printed = rings + np.sign(rings) * [0.0, _PRINT, _PRINT]
    fields = [
        lofted(printed[first // every : max(last // every, first // every + 1) + 1]) for first, last in sku.fields
    ]
    body, field = _fitted([lofted(rings), merge(fields)], size)
    return model_of(
        name,
        "sack",
        sku.obj_id,
        size,
        (
            mesh_part(body, material),
            mesh_part(field, sku.print_material),
        ),
        mass=sku.mass,
    )


def _rings(seed: int) -> Float[np.ndarray, "stations points 3"]:
    """Return the outlines along a sack that reaches from about -1 to 1 along each axis.

    An outline is a superellipse; towards the ends it gets flatter and a little narrower, as the fill does not reach the
    seams. Low waves wrinkle it.
    """
    rng = np.random.default_rng(seed)
    along = np.linspace(-1.0, 1.0, _STATIONS + 1)
    flat = 1.0 - 0.50 * np.abs(along) ** 9
    slim = 1.0 - 0.06 * np.abs(along) ** 6
    angles = np.arange(_AROUND) * 2 * np.pi / _AROUND
    cosine, sine = np.cos(angles), np.sin(angles)
    y = np.sign(cosine) * np.abs(cosine) ** (2 / 4.5)
    z = np.sign(sine) * np.abs(sine) ** (2 / 4.5)
    phases = rng.uniform(0.0, 2 * np.pi, (6, 2))
    waves = sum(
        np.cos((k + 1) * np.pi * along[:, None] + phases[k, 0]) * np.cos((k % 3 + 2) * angles + phases[k, 1]) / (k + 2)
        for k in range(6)
    )
    swell = 1.0 + 0.035 * np.asarray(waves) * np.abs(sine)
    x = np.repeat(along[:, None], _AROUND, axis=1)
    return np.stack([x, slim[:, None] * y, flat[:, None] * z * swell], axis=2)


def _slumped(rings: Float[np.ndarray, "stations points 3"], seed: int) -> Float[np.ndarray, "stations points 3"]:
    """Return outlines of a filling that has run: more at one end, a crease across, ends that hang, a little bent."""
    rng = np.random.default_rng([seed, 1])
    x, y, z = np.moveaxis(rings, 2, 0)
    run, bend, belly = rng.uniform(-0.16, 0.16), rng.uniform(-0.05, 0.05), rng.uniform(0.02, 0.09)
    crease, depth, tilt = rng.uniform(-0.6, 0.6), rng.uniform(0.03, 0.14), rng.uniform(-0.5, 0.5)
    thick = (1.0 + run * x) * (1.0 - depth * np.exp(-(((x - crease - 0.3 * tilt * y) / 0.09) ** 2)))
    hang = rng.uniform(0.1, 0.45, 2)
    droop = np.where(x < 0, hang[0], hang[1]) * np.maximum(np.abs(x) - 0.72, 0.0) ** 1.3 * 2.0
    upper = np.where(z > 0, z * thick, z)
    wide = y * (1.0 + belly * np.cos(2.2 * x + rng.uniform(-1.0, 1.0))) + bend * (1.0 - x**2)
    corner = 1.0 - rng.uniform(0.0, 0.10) * np.abs(y) ** 3 * np.abs(x) ** 6
    return np.stack([x * corner, wide, upper - droop], axis=2)


def _fitted(meshes: list[TriangleMesh], size: np.ndarray) -> list[TriangleMesh]:
    """Return ``meshes`` shifted and stretched together so that they fill ``size`` (m) around the origin."""
    points = np.concatenate([mesh.vertices for mesh in meshes])
    low, high = points.min(axis=0), points.max(axis=0)
    return [TriangleMesh((mesh.vertices - (low + high) / 2) / (high - low) * size, mesh.faces) for mesh in meshes]
