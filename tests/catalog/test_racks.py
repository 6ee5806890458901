import numpy as np
import pytest

from warehouse_sim.catalog import rack_beam, rack_frame
from warehouse_sim.catalog.racks import BAY_WIDTH, CONNECTOR_HEIGHT, FRAME_DEPTH, FRAME_HEIGHTS
from warehouse_sim.errors import UnknownNameError


@pytest.mark.parametrize("name", FRAME_HEIGHTS)
def test_uprights_reach_from_the_floor_to_the_height(name: str) -> None:
    model, height = rack_frame(name), FRAME_HEIGHTS[name]
    blue = [part.placed().vertices for part in model.parts if part.material == "rack_blue"]
    for vertices in blue:
        assert vertices[:, 2].min() == pytest.approx(-height / 2)
        assert vertices[:, 2].max() == pytest.approx(height / 2)
    y = np.concatenate(blue)[:, 1]
    assert (y.min(), y.max()) == (pytest.approx(-FRAME_DEPTH / 2), pytest.approx(FRAME_DEPTH / 2))


def test_lacing_stays_between_the_uprights_and_diagonals_are_inclined() -> None:
    model = rack_frame("rack_frame_4500")
    inner = FRAME_DEPTH / 2 - 0.08
    bars = [part for part in model.parts if part.material == "galvanised" and abs(part.T_object_part[1, 3]) < 1e-9]
    assert len(bars) >= 8
    for bar in bars:
        assert np.abs(bar.placed().vertices[:, 1]).max() <= inner + 1e-9
        assert np.abs(bar.placed().vertices[:, 2]).max() <= model.size[2] / 2
    inclined = [bar for bar in bars if abs(bar.T_object_part[1, 2]) > 0.1]
    assert {np.sign(bar.T_object_part[1, 2]) for bar in inclined} == {-1.0, 1.0}


def test_a_beam_spans_the_bay_with_its_top_at_the_top_of_its_box() -> None:
    beam = rack_beam()
    vertices = beam.mesh().vertices
    assert vertices[:, 0].max() - vertices[:, 0].min() == pytest.approx(BAY_WIDTH)
    top = next(box for box in beam.collision if box.size[0] == BAY_WIDTH)
    assert top.corners()[:, 2].max() == pytest.approx(CONNECTOR_HEIGHT / 2)


def test_an_unknown_frame_lists_the_known_ones() -> None:
    with pytest.raises(UnknownNameError, match="rack_frame_4500"):
        rack_frame("rack_frame_1")
