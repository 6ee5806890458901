"""Parts of the building that are made to size: measures, openings, and that they are closed bodies."""

import numpy as np
import pytest

from tests.catalog.covering import shipped
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.building import to_size
from warehouse_sim.catalog.building.floor_litter import THICK, floor_litter
from warehouse_sim.catalog.building.floor_marks import STAINS, TYRE_TRACK, VARIANTS, floor_stain, tyre_tracks
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


FLAT = [name for name in shipped("building") if catalog_object(name).class_name == "marking"]


@pytest.mark.parametrize("name", FLAT)
def test_what_is_painted_is_flat_and_stops_nothing(name: str) -> None:
    model = catalog_object(name)
    assert model.size[2] <= 0.001
    assert model.collision == ()
    assert model.mass == 0.0


def test_both_colours_of_a_line_are_one_geometry() -> None:
    yellow, white = catalog_object("lane_line_yellow_3000"), catalog_object("lane_line_white_3000")
    assert yellow.obj_id == white.obj_id
    assert (yellow.parts[0].material, white.parts[0].material) == ("marking_yellow", "marking_white")


def test_straight_tyre_marks_are_two_tracks_apart_that_thin_out() -> None:
    vertices = catalog_object("tyre_mark_straight").mesh().vertices
    for side in (-1.0, 1.0):
        track = vertices[np.sign(vertices[:, 1]) == side]
        assert track[:, 1].mean() == pytest.approx(side * TYRE_TRACK / 2)
        ends = track[track[:, 0] > track[:, 0].max() - 1e-9]
        middle = track[np.abs(track[:, 0]) < 0.15]
        assert np.ptp(ends[:, 1]) < 0.25 * np.ptp(middle[:, 1])


def test_a_curved_tyre_mark_runs_on_two_circles() -> None:
    model = catalog_object("tyre_mark_curve")
    vertices = model.mesh().vertices
    # The ring's centre is the corner of the bounding box that the tracks bend around.
    outer = vertices[np.argmax(vertices[:, 0])]
    centre = np.array([outer[0] - 2.4, outer[1]])
    radius = np.linalg.norm(vertices[:, :2] - centre, axis=1)
    assert set(np.round((radius - 2.4) / TYRE_TRACK)) == {0.0, -1.0}


# Dust and litter lie flat within the box of the tracks, which stand where they stood.


LITTER = {"floor_dust", "floor_board", "floor_film", "floor_splinter", "floor_strap"}
LOW, HIGH = np.array([-8.0, -1.3]), np.array([8.0, 1.4])


@pytest.mark.parametrize("seed", range(12))
def test_all_is_flat_and_within_bounds(seed: int) -> None:
    found = floor_litter(16.0, 3.0, LOW, HIGH, np.random.default_rng(seed))
    assert {"floor_dust", "floor_splinter"} <= found.keys() <= LITTER
    for mesh in found.values():
        assert (mesh.vertices[:, :2] > LOW).all()
        assert (mesh.vertices[:, :2] < HIGH).all()
        assert np.abs(mesh.vertices[:, 2]).max() == pytest.approx(THICK / 2)
        assert mesh.face_areas().min() > 0.0


def test_most_of_it_lies_at_the_sides() -> None:
    places = []
    for seed in range(30):
        found = floor_litter(30.0, 3.0, 2 * LOW, 2 * HIGH, np.random.default_rng(seed))
        places += [mesh.vertices[:, 1] for name, mesh in found.items() if name != "floor_strap"]
    assert np.mean(np.abs(np.concatenate(places)) > 0.25 * 3.0) > 0.6


@pytest.mark.parametrize("variant", range(VARIANTS))
def test_litter_leaves_the_tracks_in_place_and_hides_nothing_from_sensors(variant: int) -> None:
    model = tyre_tracks(16.0, 3.0, 7, variant)
    tracks = np.concatenate([part.placed().vertices for part in model.parts if part.material.startswith("tyre_")])
    np.testing.assert_allclose(tracks.max(axis=0), model.size / 2, atol=1e-9)
    np.testing.assert_allclose(tracks.min(axis=0), -model.size / 2, atol=1e-9)
    assert all(materials()[part.material].opacity < 1.0 for part in model.parts)
    assert LITTER & {part.material for part in model.parts}
