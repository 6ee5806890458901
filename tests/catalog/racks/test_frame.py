import numpy as np
import pytest

from warehouse_sim.catalog.racks.pallet_racks import FRAME_DEPTH, FRAME_HEIGHTS, rack_frame
from warehouse_sim.catalog.racks.upright import UPRIGHT_DEPTH


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
