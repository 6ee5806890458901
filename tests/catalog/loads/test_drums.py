import numpy as np
import pytest

from tests.catalog.covering import volume
from warehouse_sim.catalog.loads.drums import DRUMS, drum


@pytest.mark.parametrize("name", DRUMS)
def test_collision_boxes_make_an_octagon_inside_the_drum(name: str) -> None:
    model = drum(name)
    corners = np.concatenate([box.corners() for box in model.collision])
    radius = np.linalg.norm(corners[:, :2], axis=1)
    np.testing.assert_allclose(radius, model.size[0] / 2)
    assert len(np.unique(np.round(corners[:, :2], 6), axis=0)) == 8
    np.testing.assert_allclose(np.abs(corners[:, 2]), model.size[2] / 2)


def test_drums_weigh_what_they_hold() -> None:
    steel, plastic, small = (drum(f"drum_{kind}_blue") for kind in ("steel_216", "plastic_220", "plastic_60"))
    assert steel.mass == pytest.approx(18.0 + 0.2165 * 900)
    assert plastic.mass == pytest.approx(9.5 + 220)
    assert small.mass < 60.0


@pytest.mark.parametrize(("name", "litres"), [("drum_steel_216_blue", 216.5), ("drum_plastic_220_blue", 220.0)])
def test_the_body_holds_what_its_name_says(name: str, litres: float) -> None:
    assert 1000 * volume(drum(name).parts[0].placed()) == pytest.approx(litres, rel=0.06)


def test_the_steel_drum_has_two_hoops_two_plugs_and_a_label_on_its_side() -> None:
    model = drum("drum_steel_216_blue")
    body = model.parts[0].placed().vertices
    radius = np.linalg.norm(body[:, :2], axis=1)
    hoops = np.unique(np.round(body[radius > 0.2920, 2], 6))
    assert len(hoops) == 4  # lower and upper edge of each
    plugs = [part for part in model.parts if part.material == "galvanised"]
    assert [np.sign(part.T_object_part[0, 3]) for part in plugs] == [1.0, -1.0]
    assert all(part.placed().vertices[:, 2].max() < model.size[2] / 2 for part in plugs)
    label = next(part for part in model.parts if part.material == "label_paper").placed().vertices
    assert label[:, 1].min() > 0.2
    assert np.linalg.norm(label[:, :2], axis=1).max() == pytest.approx(0.2868)
