from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from warehouse_sim.catalog.loads.sacks import sack
from warehouse_sim.geometry.mesh import TriangleMesh, merge, unit_box
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render.conformance.scenes import spot
from warehouse_sim.render.embree import PlacedMeshes
from warehouse_sim.render.raster.light.contact import light_left
from warehouse_sim.render.raster.light.lighting import LIGHT, MAX_LIGHTS, ShadedLight, light_records
from warehouse_sim.render.raster.light.shadow_shapes import shadow_shape


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> TriangleMesh:
    size, centre = np.subtract(high, low), np.add(high, low) / 2.0
    return TriangleMesh(unit_box().vertices * size + centre, unit_box().faces)


def open_tote(x: float = 0.0) -> TriangleMesh:
    """An open box of 0.6 x 0.4 x 0.3 m with a row of ribs, its walls reaching into each other."""
    walls = [
        box((0, 0, 0), (0.6, 0.4, 0.01)),
        box((0, 0, 0), (0.01, 0.4, 0.3)),
        box((0.59, 0, 0), (0.6, 0.4, 0.3)),
        box((0, 0, 0), (0.6, 0.01, 0.3)),
        box((0, 0.39, 0), (0.6, 0.4, 0.3)),
    ]
    ribs = [box((0.05 * k, 0.002, 0.02), (0.05 * k + 0.01, 0.398, 0.28)) for k in range(1, 11)]
    whole = merge([*walls, *ribs])
    return TriangleMesh(whole.vertices + np.array([x, 0.0, 0.0]), whole.faces)


def reach(mesh: TriangleMesh, directions: np.ndarray) -> np.ndarray:
    return np.asarray((mesh.vertices @ directions.T).max(axis=0))


def shadow(mesh: TriangleMesh, direction: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return by exact rays which of ``points`` behind the mesh are in its shadow."""
    return PlacedMeshes([[mesh]], [(0, np.eye(4))]).blocked(points, np.tile(-direction, (len(points), 1)), np.inf)


@pytest.mark.parametrize("name", ["sack_woven_590x390x140", "sack_paper_600x400x110", "sack_white_600x400x120_4"])
def test_a_sack_casts_its_shadow_with_a_fifth_of_its_faces(name: str) -> None:
    body = sack(name).parts[0].mesh
    shape = shadow_shape(body)
    assert 5 * len(shape.faces) <= len(body.faces)
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(200, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    short = reach(body, directions) - reach(shape, directions)
    assert short.min() > -1e-6
    assert short.max() < 0.05 * np.ptp(body.vertices, axis=0).min()
    slant = np.array([0.3, 0.2, -1.0]) / np.linalg.norm([0.3, 0.2, -1.0])
    floor = np.concatenate([rng.uniform(-0.5, 0.5, (20_000, 2)), np.full((20_000, 1), -0.4)], axis=1)
    assert (shadow(body, slant, floor) != shadow(shape, slant, floor)).mean() < 0.01


def test_the_faces_of_a_hull_look_outwards() -> None:
    shape = shadow_shape(sack("sack_woven_590x390x140").parts[0].mesh)
    a, b, c = np.moveaxis(shape.vertices[shape.faces], 1, 0)
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0
    assert volume == pytest.approx(ConvexHull(shape.vertices).volume)


def test_what_is_hollow_keeps_its_faces_unless_nobody_sees_into_it() -> None:
    tote = open_tote()
    assert shadow_shape(tote) is tote
    filled = shadow_shape(tote, filled=True)
    assert len(filled.faces) == 12
    assert np.allclose([filled.vertices.min(axis=0), filled.vertices.max(axis=0)], [[0, 0, 0], [0.6, 0.4, 0.3]])


def test_totes_side_by_side_stay_apart() -> None:
    pair = shadow_shape(merge([open_tote(), open_tote(0.62)]), filled=True)
    gap = np.array([[0.61, 0.2, -0.1], [0.3, 0.2, -0.1], [0.9, 0.2, -0.1]])
    assert shadow(pair, np.array([0.0, 0.0, -1.0]), gap).tolist() == [False, True, True]


def test_a_profile_is_no_bar_of_solid_steel() -> None:
    """Its hull would let light in through the slots of an upright, and fill the step of a beam."""
    channel = merge([
        *(box((0, 0, 0.02 * k), (0.08, 0.002, 0.02 * k + 0.015)) for k in range(40)),
        *(box((0, 0, 0.02 * k), (0.002, 0.06, 0.02 * k + 0.02)) for k in range(40)),
    ])  # fmt: skip
    assert shadow_shape(channel) is channel


def test_small_meshes_and_flat_ones_are_left_alone() -> None:
    assert shadow_shape(unit_box()) is unit_box()
    steps = np.linspace(0.0, 1.0, 12)
    vertices = np.array([(x, y, 0.0) for x in steps for y in steps])
    corner = np.array([12 * i + j for i in range(11) for j in range(11)])
    faces = np.concatenate([corner[:, None] + [0, 12, 13], corner[:, None] + [0, 13, 1]]).astype(np.int32)
    sheet = TriangleMesh(vertices, faces)
    assert shadow_shape(sheet) is sheet
    assert shadow_shape(sheet, filled=True) is sheet


# What the map of the floor keeps of its light: nothing is lost far away, half at a wall, most under a deck.


TEXEL = 0.02
STANDS, DECK = 0.1 / 1000.0, 0.1 / 1000.1
"""``near`` / z of what touches the floor, and of what is 10 cm above it."""


def kept(stored: np.ndarray) -> np.ndarray:
    return light_left(stored.astype(np.float32), TEXEL) / 255.0


def test_an_empty_floor_keeps_all() -> None:
    assert (kept(np.zeros((64, 80))) == 1.0).all()


def test_a_wall_takes_half_of_the_light_at_its_foot_and_none_half_a_metre_away() -> None:
    stored = np.zeros((200, 200))
    stored[:, :100] = STANDS
    row = kept(stored)[100]
    assert 0.35 < row[100] < 0.5
    assert (np.diff(row[100:]) >= 0.0).all()
    assert row[100 + round(0.07 / TEXEL)] > row[100] + 0.2
    assert row[100 + round(0.5 / TEXEL)] > 0.98


def test_a_deck_above_the_floor_has_a_softer_rim_than_a_foot() -> None:
    rims = []
    for height in (STANDS, DECK):
        stored = np.zeros((200, 200))
        stored[:, :100] = height
        rims.append(kept(stored)[100])
    assert rims[1][100] == pytest.approx(0.63, abs=0.05)
    assert rims[1][100] > rims[0][100] + 0.15
    assert rims[1][140] == pytest.approx(rims[0][140], abs=0.01)


def test_what_hangs_higher_does_not_count() -> None:
    assert (kept(np.full((64, 64), 0.1 / 1000.3)) == 1.0).all()


T_WORLD_CAMERA = level_camera(np.array([0.0, 0.0, 1.5]), 0.0)


def test_records_hold_the_light_in_the_camera_frame() -> None:
    light = replace(spot((4.0, 1.0, 6.0), 500.0), color=(1.0, 0.5, 0.25), cone_inner=0.5, cone_outer=1.0)
    records = light_records([ShadedLight(light, None)], T_WORLD_CAMERA)
    assert records.dtype == LIGHT
    assert len(records) == MAX_LIGHTS
    np.testing.assert_allclose(records[0]["position"], [-1.0, -4.5, 4.0], atol=1e-6)
    np.testing.assert_allclose(records[0]["axis"], [0.0, 1.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(records[0]["intensity"], [500.0, 250.0, 125.0])
    for angle, expected in ((0.5, 1.0), (1.0, 0.0)):
        value = np.cos(angle) * records[0]["cone_scale"] + records[0]["cone_offset"]
        assert value == pytest.approx(expected, abs=1e-5)
    assert not records[1:].view(np.uint8).any()
