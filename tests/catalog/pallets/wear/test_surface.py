import numpy as np
import pytest

from tests.catalog.pallets.wear.used import made, of_material, ruined, wood
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.materials import materials
from warehouse_sim.catalog.pallets import PALLETS
from warehouse_sim.catalog.pallets.wear.brands import SKIN, framed_brand, lettering, oval_brand
from warehouse_sim.catalog.pallets.wear.damaged import STAGES, WearConfig, stain_shape
from warehouse_sim.geometry.pose import rotation_z


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


NONE = WearConfig(stamps=0.0)


def test_all_stages_are_materials_and_every_pallet_can_age() -> None:
    stages = [name for line in STAGES for name in line]
    assert set(stages) <= set(materials())
    assert len(set(stages)) == len(stages)
    for name in PALLETS:
        used = {part.material for part in catalog_object(name).parts} - {"galvanised"}
        assert used <= set(stages)


def test_age_goes_from_the_own_look_to_grey() -> None:
    assert [part.material for part in wood(ruined("epal1", 1, NONE))] == [
        part.material for part in catalog_object("epal1").parts
    ]
    fractions = []
    for age in (0.2, 0.6, 1.0):
        used = [part.material for seed in range(10) for part in wood(ruined("epal1", seed, WearConfig(age=age)))]
        fractions.append(np.mean([material.endswith(("grey", "dark")) for material in used]))
    assert fractions[0] < 0.15 < fractions[1] < fractions[2]
    assert fractions[2] > 0.75


def test_plastic_gets_dusty_all_over() -> None:
    looks = [{p.material for p in ruined("plastic_runners", seed, WearConfig(age=0.5)).parts} for seed in range(8)]
    assert all(len(look) == 1 for look in looks)
    assert {"plastic_grey"} in looks
    assert {"plastic_grey_dusty"} in looks


# Brands, stencils and their letters.


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
