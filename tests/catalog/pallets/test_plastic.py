import numpy as np

from tests.catalog.pallets.touching import reaches_into
from warehouse_sim.catalog.pallets import pallet
from warehouse_sim.geometry.pose import make_transform


def test_the_runner_pallet_keeps_the_clear_widths_of_its_specification() -> None:
    model = pallet("plastic_runners")
    windows = {pocket.face: pocket for pocket in model.pockets}
    between_outer = {
        face: 2 * abs(p.T_object_pocket[1 - "xy".index(face[1]), 3]) + p.size[1] for face, p in windows.items()
    }
    assert between_outer["-x"] >= 0.595
    assert between_outer["-y"] >= 0.900
    assert windows["-x"].size[2] >= 0.090
    assert 0.100 <= round(windows["-y"].size[2], 9) <= 0.103
    assert 0.144 <= model.size[2] <= 0.151
    assert model.mass <= 18.0


def test_feet_stand_under_the_mouths_of_the_deck() -> None:
    model = pallet("plastic_nestable")
    deck, feet = model.parts[0], model.parts[1:]
    assert len(feet) == 9
    assert len({part.mesh for part in feet}) == 1
    for foot in feet:
        x, y, _ = foot.T_object_part[:3, 3]
        mouth = make_transform(translation=np.array([x, y, 0.0]))
        assert not reaches_into(deck.placed(), mouth, np.array([0.13, 0.085, 0.3]))
