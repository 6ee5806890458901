"""Frames and beams fit each other and pallets, and lean no more than the standard allows."""

import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.racks.accessories import DECK_DEPTH
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
from warehouse_sim.catalog.racks.upright import UPRIGHT_DEPTH
from warehouse_sim.geometry.pose import transform_points


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
