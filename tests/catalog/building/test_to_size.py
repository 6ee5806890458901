"""Parts of the building that are made to size: measures, openings, and that they are closed bodies."""

import numpy as np
import pytest

from warehouse_sim.catalog.building import to_size
from warehouse_sim.catalog.building.floor_marks import STAINS, VARIANTS, floor_stain, tyre_tracks
from warehouse_sim.catalog.building.outdoors import OUTDOORS, RISE, SKY_RADIUS, YARD_DROP, outdoors
from warehouse_sim.catalog.building.to_size import (
    column_to_size,
    girder_to_size,
    roof_to_size,
    slab_to_size,
    wall_to_size,
)
from warehouse_sim.catalog.materials import materials
from warehouse_sim.schema import ObjectModel

DOORS = ((-6.0, 2.75, 3.0), (0.0, 2.75, 3.0))
MODELS = (
    *(slab_to_size(kind, 21.4, 13.7) for kind in ("concrete", "jointed", "epoxy")),
    *(wall_to_size(kind, 20.4, 6.3, DOORS) for kind in ("panels", "cladding", "sandwich", "blockwork", "plaster")),
    *(roof_to_size(kind, 20.4, 13.0) for kind in ("truss", "beam", "board")),
    *(girder_to_size(kind, span) for kind in ("truss", "beam") for span in (10.0, 31.0, 120.0)),
    *(column_to_size(kind, 5.5) for kind in ("steel", "concrete")),
    to_size.sprinkler_line(17.3),
    to_size.cable_tray(17.3),
    to_size.duct(17.3),
    to_size.light_line(17.3),
    to_size.rooflight(5.5),
    to_size.window_band(6.0),
    to_size.hanging_rods(1.4),
    tyre_tracks(20.0, 3.5, 9, 3),
    *(floor_stain(kind, variant) for kind in STAINS for variant in range(VARIANTS)),
)


def _volume(model: ObjectModel, number: int) -> float:
    mesh = model.parts[number].placed()
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.name)
def test_size_is_that_of_the_mesh_and_parts_are_solid_and_painted(model: ObjectModel) -> None:
    corners = model.mesh().vertices
    np.testing.assert_allclose(np.ptp(corners, axis=0), model.size, atol=1e-6)
    np.testing.assert_allclose(corners.min(axis=0) + corners.max(axis=0), 0.0, atol=1e-6)
    assert all(_volume(model, number) > 0.0 for number in range(len(model.parts)))
    assert {part.material for part in model.parts} <= set(materials())
    assert 400 <= model.obj_id <= 499 or model.obj_id in (142, 143, 145, 146)


def test_a_wall_is_open_where_its_doors_are_and_nowhere_else() -> None:
    wall = wall_to_size("blockwork", 20.4, 6.3, DOORS)
    area = sum(float(box.size[0] * box.size[2]) for box in wall.collision)
    # Collision boxes leave the frames out, which are 0.1 m wide.
    assert area == pytest.approx(20.4 * 6.3 - 2 * (2.75 + 0.2) * 3.1, abs=1e-9)


def test_the_sky_is_closed_and_looks_inward() -> None:
    model = outdoors("outdoors", 40.0, 30.0)
    assert model.class_name == OUTDOORS
    assert not model.collision
    for number, part in enumerate(model.parts):
        if part.material.startswith("outdoor_sky"):
            assert _volume(model, number) < 0.0
    rng = np.random.default_rng(1)
    rays = rng.normal(size=(400, 3))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    mesh = model.mesh()
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] + [0.0, 0.0, RISE] for corner in range(3))
    normal = np.cross(b - a, c - a)
    eye = np.array([3.0, -4.0, 1.6])
    for ray in rays:  # Moeller and Trumbore would do; here by planes and half-planes
        t = ((a - eye) * normal).sum(axis=1) / (normal @ ray + 1e-300)
        hit = eye + t[:, None] * ray
        inside = np.ones(len(a), dtype=bool)
        for start, end in ((a, b), (b, c), (c, a)):
            inside &= (np.cross(end - start, hit - start) * normal).sum(axis=1) >= -1e-6
        first = t[inside & (t > 0.0)].min()
        assert 0.0 < first <= SKY_RADIUS + 5.0
    low = model.mesh().vertices[:, 2].min() + RISE
    assert low < -YARD_DROP
