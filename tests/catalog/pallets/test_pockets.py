import numpy as np
import pytest

from warehouse_sim.catalog.pallets.pockets import Window, pockets_behind, window_between

SIZE = np.array([1.2, 0.8, 0.144])


def test_the_window_is_what_three_uprights_leave() -> None:
    window = window_between(0.1, 0.145, 0.8, 0.022, 0.122)
    assert window.width == pytest.approx(0.2275)
    assert window.offset == pytest.approx(0.18625)
    assert window.offset - window.width / 2 == pytest.approx(0.145 / 2)
    assert window.offset + window.width / 2 == pytest.approx(0.4 - 0.1)


@pytest.mark.parametrize(("face", "opening"), [("-x", -0.6), ("+x", 0.6), ("-y", -0.4), ("+y", 0.4)])
def test_both_prisms_begin_on_the_face_and_end_on_the_opposite_one(face: str, opening: float) -> None:
    pair = pockets_behind({face: Window(0.2, 0.15, 0.02, 0.12)}, SIZE)
    assert [pocket.face for pocket in pair] == [face, face]
    along = "xy".index(face[1])
    for pocket in pair:
        place = pocket.T_object_pocket[:3, 3]
        assert place[along] == pytest.approx(opening)
        assert abs(place[1 - along]) == pytest.approx(0.15)
        assert place[2] == pytest.approx(0.07 - 0.072)
        np.testing.assert_allclose(pocket.size, [SIZE[along], 0.2, 0.1])
        end = pocket.T_object_pocket @ [pocket.size[0], 0.0, 0.0, 1.0]
        assert end[along] == pytest.approx(-opening)
    assert pair[0].T_object_pocket[1 - along, 3] == pytest.approx(-pair[1].T_object_pocket[1 - along, 3])
