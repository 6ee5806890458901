import numpy as np
import pytest

from tests.catalog.pallets.wear.used import made, of_material
from warehouse_sim.catalog.pallets.wear.surface import stain_shape


def test_nails_sit_on_the_deck_above_what_carries_it() -> None:
    heads = of_material(made("epal1"), "nail_steel")
    assert len(heads) == 5
    for part in heads:
        vertices = part.placed().vertices
        assert vertices[:, 2].max() == pytest.approx(0.072 + 0.0003)
        for place in (-0.5275, 0.0, 0.5275):
            assert np.sum(np.abs(vertices[:, 0] - place) < 0.006) == len(vertices) / 3


def test_stains_stay_on_their_board() -> None:
    model = made("epal1", stains=1.0)
    stains = of_material(model, "wood_stain")
    assert len(stains) >= 5
    boards = [part for part in model.parts if part.material == "pallet_wood" and part.T_object_part[2, 3] > 0.06]
    for stain in stains:
        low, high = stain.placed().vertices.min(axis=0), stain.placed().vertices.max(axis=0)
        inside = [
            np.all(low[:2] >= v.min(axis=0)[:2] - 1e-9) and np.all(high[:2] <= v.max(axis=0)[:2] + 1e-9)
            for v in (board.placed().vertices for board in boards)
        ]
        assert sum(inside) == 1


def test_stain_shapes_differ_and_fill_their_square() -> None:
    shapes = [stain_shape(number) for number in range(6)]
    for shape in shapes:
        np.testing.assert_allclose(np.ptp(shape.vertices, axis=0), 1.0)
    assert len({shape.vertices.tobytes() for shape in shapes}) == 6
    assert stain_shape(0) is shapes[0]


def test_paint_comes_off_where_others_have_stains() -> None:
    painted = made("blue_block_1200x1000", stains=1.0)
    assert of_material(painted, "wood_stain") == []
    assert len(of_material(painted, "pallet_wood_tan")) >= 7
