"""Brands, stencils and their letters."""

import numpy as np
import pytest

from tests.catalog.pallets.wear.used import made, of_material
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.pallets.wear.brands import SKIN, framed_brand, lettering, oval_brand
from warehouse_sim.geometry.pose import rotation_z


@pytest.mark.parametrize(("name", "count"), [("epal1", 6), ("epal2", 6), ("epal6", 6), ("epal7", 6), ("gma_48x40", 2)])
def test_brands_are_on_both_long_sides(name: str, count: int) -> None:
    model = made(name)
    marks = of_material(model, "brand_mark")
    assert len(marks) == count
    for mark in marks:
        x, y, _ = mark.T_object_part[:3, 3]
        side = np.sign(y)
        assert abs(y) == pytest.approx(model.size[1] / 2)
        # Out of the wood, upright, and legible: its x axis to the right of who looks at it.
        np.testing.assert_allclose(mark.T_object_part[:3, 2], [0, side, 0], atol=1e-12)
        np.testing.assert_allclose(mark.T_object_part[:3, 1], [0, 0, 1], atol=1e-12)
        np.testing.assert_allclose(mark.T_object_part[:3, 0], [-side, 0, 0], atol=1e-12)
        assert mark.placed().vertices[:, 2].max() < model.size[2] / 2
        assert abs(x) < model.size[0] / 2


def test_a_brand_lies_on_the_block_and_follows_it_when_that_is_turned() -> None:
    straight, turned = made("epal1"), made("epal1", twisted=1.0)
    for one, two in zip(of_material(straight, "brand_mark"), of_material(turned, "brand_mark"), strict=True):
        assert np.abs(one.placed().vertices[:, 1]).max() == pytest.approx(0.4 + SKIN)
        angle = np.arctan2(two.T_object_part[0, 2], two.T_object_part[1, 2])
        assert abs(np.sin(angle)) > 0.02


def test_pool_pallets_bear_their_owner_and_plastic_ones_nothing() -> None:
    assert len(of_material(made("blue_block_1200x1000"), "stencil_white")) == 4
    assert len(made("plastic_runners").parts) == len(catalog_object("plastic_runners").parts)


def test_illegible_marks_are_gone() -> None:
    assert of_material(made("epal1", stamps=0.0), "brand_mark") == []


def test_lettering_reads_the_same_after_a_half_turn_of_the_pallet() -> None:
    marks = of_material(made("epal1"), "brand_mark")
    places = {tuple(np.round(mark.T_object_part[:3].ravel(), 9) + 0.0) for mark in marks}
    half_turn = np.eye(4)
    half_turn[:3, :3] = np.round(rotation_z(np.pi))
    turned = {tuple(np.round((half_turn @ mark.T_object_part)[:3].ravel(), 9) + 0.0) for mark in marks}
    assert places == turned


def test_letters_are_drawn_as_their_rows_say() -> None:
    mesh = lettering(("L",))
    columns = [tuple(np.round(corner, 6)) for corner in mesh.vertices[mesh.vertices[:, 1] < -0.499][:, :2]]
    assert (-0.5, -0.5) in columns
    assert (0.5, -0.5) in columns
    upper = mesh.vertices[mesh.vertices[:, 1] > 0.0]
    assert upper[:, 0].max() == pytest.approx(-0.3)  # one of five columns


def test_texts_and_frames_fill_the_unit_cube() -> None:
    for mesh in (lettering(("HT",)), oval_brand("EPAL"), framed_brand(("IPPC", "HT"))):
        np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), 1.0, atol=1e-9)
    wide, narrow = (framed_brand((text,)) for text in ("IPPC-0", "I"))
    assert len(wide.faces) > len(narrow.faces)


def test_an_unknown_letter_is_an_error() -> None:
    with pytest.raises(KeyError):
        lettering(("Q",))
