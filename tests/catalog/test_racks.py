"""Frames and beams fit each other and pallets, and lean no more than the standard allows."""

import numpy as np
import pytest

from tests.catalog.covering import volume
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.racks.accessories import DECK_DEPTH, DECK_WIDTH
from warehouse_sim.catalog.racks.pallet_racks import (
    BAY_WIDTH,
    BAY_WIDTHS,
    BEAM_DEPTH,
    BEAM_HEIGHT,
    CONNECTOR_HEIGHT,
    CONNECTOR_LEG,
    CONNECTOR_SHEET,
    FRAME_DEPTH,
    FRAME_HEIGHTS,
    STEP_BEAM_DEPTH,
    STEP_DEPTH,
    STEP_HEIGHT,
    beam_pose,
    frame_pose,
    rack_frame,
)
from warehouse_sim.catalog.racks.upright import (
    HOLE_BOTTOM,
    HOLE_HEIGHT,
    HOLE_OUTER,
    HOLE_PITCH,
    HOLE_TOP,
    SHEET,
    UPRIGHT_DEPTH,
    UPRIGHT_WIDTH,
    hole_heights,
    upright_mesh,
)
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import Material, ObjectInstance, ObjectModel, Part, SceneSpec


@pytest.mark.parametrize("name", FRAME_HEIGHTS)
def test_uprights_reach_from_the_floor_to_the_height(name: str) -> None:
    model, height = rack_frame(name), FRAME_HEIGHTS[name]
    blue = [part.placed().vertices for part in model.parts if part.material == "rack_blue"]
    assert len(blue) == 2
    for vertices in blue:
        assert vertices[:, 2].min() == pytest.approx(-height / 2)
        assert vertices[:, 2].max() == pytest.approx(height / 2)
    y = np.concatenate(blue)[:, 1]
    assert (y.min(), y.max()) == (pytest.approx(-FRAME_DEPTH / 2), pytest.approx(FRAME_DEPTH / 2))


def test_lacing_stays_between_the_uprights_and_diagonals_are_inclined() -> None:
    model = rack_frame("rack_frame_4500")
    inner = FRAME_DEPTH / 2 - UPRIGHT_DEPTH
    bars = [box for box in model.collision if abs(box.T_parent_box[1, 3]) < 1e-9]
    assert len(bars) >= 8
    for bar in bars:
        assert np.abs(bar.corners()[:, 1]).max() <= inner + 1e-9
        assert np.abs(bar.corners()[:, 2]).max() <= model.size[2] / 2
    inclined = [bar for bar in bars if abs(bar.T_parent_box[1, 2]) > 0.1]
    assert {np.sign(bar.T_parent_box[1, 2]) for bar in inclined} == {-1.0, 1.0}


def test_names_numbers_and_parts_are_few_and_fixed() -> None:
    numbers = {name: rack_frame(name).obj_id for name in FRAME_HEIGHTS}
    assert list(numbers.values()) == [*range(101, 108), 500, 501, 502]
    assert numbers["rack_frame_4500"] == 104
    assert all(len(rack_frame(name).parts) == 3 for name in FRAME_HEIGHTS)


def test_a_beam_spans_the_bay_with_its_top_at_the_top_of_its_box() -> None:
    beam = catalog_object(f"rack_beam_{1000 * BAY_WIDTH:.0f}")
    vertices = beam.mesh().vertices
    assert vertices[:, 0].max() - vertices[:, 0].min() == pytest.approx(BAY_WIDTH)
    top = next(box for box in beam.collision if box.size[0] == BAY_WIDTH)
    assert top.corners()[:, 2].max() == pytest.approx(CONNECTOR_HEIGHT / 2)


@pytest.mark.parametrize("length", BAY_WIDTHS)
def test_a_step_beam_fits_between_uprights_and_over_their_fronts(length: float) -> None:
    beam = catalog_object(f"step_beam_{1000 * length:.0f}")
    np.testing.assert_allclose(beam.size, [length + 2 * CONNECTOR_LEG, STEP_BEAM_DEPTH, CONNECTOR_HEIGHT])
    orange = next(part for part in beam.parts if part.material == "rack_orange").placed().vertices
    behind = orange[orange[:, 1] > -STEP_BEAM_DEPTH / 2 + CONNECTOR_SHEET + 1e-9]
    assert np.abs(behind[:, 0]).max() == pytest.approx(length / 2)


def test_the_ledge_of_a_step_beam_lies_at_its_back_under_the_top() -> None:
    beam = catalog_object("step_beam_2700")
    body = sorted((box for box in beam.collision if box.size[0] == BAY_WIDTH), key=lambda box: box.size[1])
    front, ledge = body
    assert ledge.corners()[:, 2].max() == pytest.approx(CONNECTOR_HEIGHT / 2 - STEP_HEIGHT)
    assert front.corners()[:, 2].max() == pytest.approx(CONNECTOR_HEIGHT / 2)
    assert ledge.corners()[:, 1].max() - front.corners()[:, 1].max() == pytest.approx(STEP_DEPTH)
    assert ledge.corners()[:, 2].min() == pytest.approx(CONNECTOR_HEIGHT / 2 - BEAM_HEIGHT)


def test_decks_and_bars_lie_on_the_ledges_of_two_beams_flush_with_their_tops() -> None:
    between_fronts = FRAME_DEPTH - 2 * (BEAM_DEPTH - STEP_DEPTH)
    between_ledges = FRAME_DEPTH - 2 * BEAM_DEPTH
    for name in ("mesh_deck", "pallet_support_bar"):
        piece = catalog_object(name)
        assert between_ledges < piece.size[1] < between_fronts
        assert piece.size[1] == pytest.approx(DECK_DEPTH)
        assert piece.size[2] == pytest.approx(STEP_HEIGHT)


def test_widths_are_pallets_with_clearances() -> None:
    for width, pallets in ((1.825, 2), (2.7, 3), (3.6, 4)):
        assert width in BAY_WIDTHS
        assert width >= pallets * 0.8 + (pallets + 1) * 0.075 - 1e-9


@pytest.mark.parametrize("height", [2.0, 8.0])
def test_frames_lean_by_at_most_a_350th_about_their_foot(height: float) -> None:
    rng = np.random.default_rng(1)
    ends = np.array([[0.0, 0.0, -height / 2], [0.0, 0.0, height / 2]])
    leans = []
    for _ in range(300):
        foot, top = transform_points(frame_pose(height, rng), ends)
        assert foot[2] == pytest.approx(-height / 2)
        assert foot[0] == pytest.approx(0.0, abs=1e-12)
        assert abs(foot[1]) <= 0.010 + 1e-12
        leans.append(top[:2] - foot[:2])
    largest = np.abs(leans).max(axis=0)
    assert np.all(largest <= height / 350 + 1e-9)
    assert np.all(largest > 0.6 * height / 350)


def test_beam_ends_are_level_to_the_larger_of_3_mm_and_a_500th() -> None:
    rng = np.random.default_rng(2)
    for length, limit in ((1.0, 0.003), (2.7, 2.7 / 500)):
        ends = np.array([[-length / 2, 0.0, 0.0], [length / 2, 0.0, 0.0]])
        poses = np.array([beam_pose(length, rng) for _ in range(300)])
        z = transform_points(poses, np.broadcast_to(ends, (300, 2, 3)))[..., 2]
        assert 0.6 * limit < np.abs(z[:, 1] - z[:, 0]).max() <= limit
        twist = np.abs(np.rad2deg(np.arctan2(poses[:, 2, 1], poses[:, 2, 2])))
        assert 0.3 * length < twist.max() <= length / 2 + 1e-9


HEIGHTS = (2.0, 4.5, 8.0)


@pytest.mark.parametrize("height", HEIGHTS)
def test_outer_size(height: float) -> None:
    vertices = upright_mesh(height).vertices
    np.testing.assert_allclose(np.ptp(vertices, axis=0), [UPRIGHT_WIDTH, UPRIGHT_DEPTH, height], atol=1e-12)
    np.testing.assert_allclose(vertices.max(axis=0) + vertices.min(axis=0), 0.0, atol=1e-12)


@pytest.mark.parametrize("height", HEIGHTS)
def test_each_slot_takes_its_own_volume_of_steel(height: float) -> None:
    slot = (HOLE_OUTER - (HOLE_TOP + HOLE_BOTTOM) / 2) * HOLE_HEIGHT * SHEET
    other = 3.0
    solid_a = volume(upright_mesh(height)) + 2 * len(hole_heights(height)) * slot
    solid_b = volume(upright_mesh(other)) + 2 * len(hole_heights(other)) * slot
    assert solid_a / height == pytest.approx(solid_b / other, rel=1e-9)


def test_slots_have_the_pitch_of_the_beams() -> None:
    heights = hole_heights(4.5)
    np.testing.assert_allclose(np.diff(heights), HOLE_PITCH)
    np.testing.assert_allclose(heights / HOLE_PITCH, np.round(heights / HOLE_PITCH))
    assert heights[0] == pytest.approx(0.1)
    assert 4.5 - heights[-1] == pytest.approx(0.05)


def test_rays_pass_through_the_slots_and_stop_between_them() -> None:
    part = Part(upright_mesh(2.0), np.ones(3), np.eye(4), "steel")
    model = ObjectModel("upright", "rack", 1, np.array([0.1, 0.08, 2.0]), (part,), ())
    materials = {"steel": Material("steel", (0.5, 0.5, 0.5))}
    caster = RayCaster(
        SceneSpec(0, 0, {"upright": model}, materials, (ObjectInstance(1, "upright", np.eye(4)),), (), ())
    )
    levels = hole_heights(2.0) - 1.0
    for x in (-0.03, 0.03):
        through = np.column_stack([np.full(len(levels), x), np.full(len(levels), -1.0), levels])
        ahead = np.tile([0.0, 1.0, 0.0], (len(levels), 1))
        # Behind a slot lies the waist of the section, 62 mm from the front at least.
        np.testing.assert_array_less(0.96 + 0.05, caster.cast(through, ahead).distance)
        between = through + np.array([0.0, 0.0, HOLE_PITCH / 2])
        np.testing.assert_allclose(caster.cast(between, ahead).distance, 0.96, atol=1e-5)


def test_uprights_of_one_height_share_one_mesh() -> None:
    frame = catalog_object("rack_frame_4500")
    assert [part.mesh is upright_mesh(4.5) for part in frame.parts] == [True, True, False]


@pytest.mark.parametrize(
    ("name", "class_name", "size"),
    [
        ("mesh_deck", "rack", (0.88, 1.04, 0.041)),
        ("pallet_support_bar", "rack", (0.04, 1.04, 0.041)),
        ("upright_guard", "guard", (0.17, 0.14, 0.4)),
        ("rack_end_guard", "guard", (0.12, 1.2, 0.4)),
        ("load_notice", "sign", (0.6, 0.004, 0.4)),
    ],
)
def test_outer_sizes_and_classes(name: str, class_name: str, size: tuple[float, float, float]) -> None:
    model = catalog_object(name)
    assert model.class_name == class_name
    np.testing.assert_allclose(model.size, size)


def test_a_deck_is_a_mesh_with_open_cells() -> None:
    deck = catalog_object("mesh_deck").mesh()
    wires = np.unique(np.round(deck.vertices[deck.vertices[:, 2] > 0.0204, 0], 6))
    # Two sides of each wire; 18 clear cells of 44-45 mm between 19 wires.
    assert len(wires) == 2 * 19
    np.testing.assert_allclose(np.diff(wires)[1::2], (DECK_WIDTH - 0.005) / 18 - 0.005, atol=1e-5)
