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
    STEP_BEAM_DEPTH,
    STEP_DEPTH,
    STEP_HEIGHT,
)


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
