"""Pallets of any shape keep what pallets of the catalog keep: pockets that are empty, solids that leave them open."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from tests.catalog.covering import volume
from tests.catalog.pallets.touching import hits, is_closed, prism_of, reaches_into, same_points
from warehouse_sim.catalog.pallets import pallet, plans
from warehouse_sim.catalog.pallets.block_pallet import build
from warehouse_sim.catalog.pallets.parametric import PalletShape, parametric_pallet
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.mesh import unit_box
from warehouse_sim.geometry.pose import make_transform, transform_points
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.physics import settle_scene
from warehouse_sim.scene import sample_scene
from warehouse_sim.scene.packing.load_config import SampledPalletsConfig, sampled_pallets
from warehouse_sim.schema import ObjectModel

FEW = sampled_pallets(SampledPalletsConfig(count=24, seed=3))
FAMILY = sampled_pallets(load_recipe("robust_pallets").scene.loads.sampled_pallets)
"""What estimators are trained on: far from any standard."""
SAMPLED = (*FEW, *FAMILY[::4])
SHAPE = PalletShape("skids", 1.14, 0.76, 0.09, 0.02, 0.12, 0.12, 6, 0.7, 1.3, "x")


@pytest.mark.parametrize("model", SAMPLED, ids=lambda model: f"{model.name}-{model.size[0]}")
def test_pockets_are_empty_and_as_wide_and_high_as_can_be(model: ObjectModel) -> None:
    assert model.pockets
    for pocket in model.pockets:
        assert not hits(model, *prism_of(pocket, (0.5, -1e-6, -1e-6)))
        assert hits(model, *prism_of(pocket, (0.0, 0.002, -0.002)))
        assert hits(model, *prism_of(pocket, (0.0, -0.002, 0.002)))
        assert pocket.size[1] >= 0.15


@pytest.mark.parametrize("model", SAMPLED, ids=lambda model: f"{model.name}-{model.size[0]}")
def test_the_box_is_the_meshes_and_physics_leaves_the_pockets_open(model: ObjectModel) -> None:
    vertices = model.mesh().vertices
    np.testing.assert_allclose(vertices.max(axis=0), model.size / 2, atol=1e-9)
    np.testing.assert_allclose(vertices.min(axis=0), -model.size / 2, atol=1e-9)
    assert model.size[0] >= model.size[1]
    solids = BoxStack.of(model.collision)
    prisms = BoxStack.of([OrientedBox(*prism_of(pocket)) for pocket in model.pockets])
    every = np.argwhere(np.ones((len(model.collision), len(model.pockets)), dtype=bool))
    assert solids.separation(prisms, every).distance.min() > -1e-9
    assert all(is_closed(part.mesh) for part in model.parts)
    for turn in model.symmetry.transforms:
        assert same_points(vertices, transform_points(turn, vertices))


@pytest.mark.parametrize("pallets", [FEW, FAMILY], ids=["usual", "family"])
def test_every_pallet_has_a_number_and_a_geometry_of_its_own(pallets: tuple[ObjectModel, ...]) -> None:
    assert len({model.obj_id for model in pallets}) == len({model.name for model in pallets}) == len(pallets)
    assert len({tuple(model.size) for model in pallets}) == len(pallets)
    assert {model.obj_id for model in pallets} <= set(range(600, 900))


def test_the_family_of_the_training_sets_is_wide() -> None:
    sizes = np.array([model.size for model in FAMILY])
    windows = np.array([pocket.size[1:] for model in FAMILY for pocket in model.pockets])
    assert len(FAMILY) == 64
    assert sizes[:, :2].min() < 0.7
    assert sizes[:, :2].max() > 1.5
    assert sizes[:, 2].min() < 0.11
    assert sizes[:, 2].max() > 0.2
    # Most of the openings let a fork pass that is 40 mm thick, and their widths differ by more than a catalog's.
    assert windows[:, 0].min() >= 0.15
    assert np.ptp(windows[:, 0]) > 0.3
    assert (windows[:, 1] > 0.04).mean() > 0.8
    assert {part.material for model in FAMILY for part in model.parts} > {"pallet_wood", "plastic_black"}


@pytest.mark.parametrize("index", [0, 1])
def test_sampled_pallets_stand_and_carry_in_the_physics(index: int) -> None:
    recipe = load_recipe("robust_pallets")
    loads = recipe.scene.loads
    only = replace(loads, sampled_pallets=replace(loads.sampled_pallets, fraction=1.0))
    scene = sample_scene(replace(recipe.scene, loads=only), 5, index)
    settled, report = settle_scene(scene, recipe.settle)
    report.require_ok()
    sampled = [item for item in settled.instances if item.model.startswith("sampled_pallet")]
    assert len({item.model.partition("~")[0] for item in sampled}) >= 5
    assert report.toppled == ()


def test_the_first_pallets_stay_when_more_are_requested_for_and_others_come_with_another_seed() -> None:
    few = sampled_pallets(SampledPalletsConfig(count=3, seed=3))
    assert [tuple(model.size) for model in few] == [tuple(model.size) for model in FEW[:3]]
    other = sampled_pallets(SampledPalletsConfig(count=3, seed=4))
    assert all(tuple(a.size) != tuple(b.size) for a, b in zip(few, other, strict=True))


def test_an_epal1_by_numbers_weighs_about_what_it_weighs() -> None:
    shape = replace(SHAPE, length=1.2, width=0.8, opening=0.1, board=0.022, post=0.145, middle_post=0.145)
    assert 18.0 < parametric_pallet("like_epal1", 899, shape, "pallet_wood").mass < 32.0


@pytest.mark.parametrize(("field", "value"), [("opening", 0.01), ("boards", 2), ("cover", 1.2), ("length", 0.7)])
def test_shapes_that_nobody_builds_are_rejected(field: str, value: float) -> None:
    with pytest.raises(ValueError, match=field):
        replace(SHAPE, **{field: value})


PALLET = pallet("epal1")


def millimetres(values: np.ndarray) -> tuple[float, ...]:
    return tuple(round(float(1000 * value), 6) for value in values)


def test_eleven_boards_and_nine_blocks_have_the_published_sizes() -> None:
    sizes = Counter(millimetres(part.scale) for part in PALLET.parts)
    assert sizes == {
        (1200, 145, 22): 4,  # three in the deck, one below
        (1200, 100, 22): 4,  # two in the deck, two below
        (145, 800, 22): 3,
        (145, 100, 78): 6,
        (145, 145, 78): 3,
    }


def test_deck_boards_lie_in_order_with_gaps_of_41_25_mm() -> None:
    deck = sorted((p for p in PALLET.parts if p.T_object_part[2, 3] > 0.06), key=lambda p: p.T_object_part[1, 3])
    assert [round(1000 * p.scale[1]) for p in deck] == [145, 100, 145, 100, 145]
    edges = np.array([(p.T_object_part[1, 3] - p.scale[1] / 2, p.T_object_part[1, 3] + p.scale[1] / 2) for p in deck])
    np.testing.assert_allclose(edges[1:, 0] - edges[:-1, 1], 0.04125, atol=1e-12)


@pytest.mark.parametrize("plan", [plans.EPAL1, plans.EPAL2, plans.EPAL3, plans.EPAL6, plans.EPAL7, plans.BLUE_BLOCK])
def test_pieces_touch_and_none_is_inside_another(plan: plans.BlockPallet) -> None:
    parts = build(plan, "made", "pallet_wood", "pallet_block").parts
    stack = BoxStack.of([OrientedBox(part.T_object_part, part.scale) for part in parts])
    pairs = np.array([(a, b) for a in range(len(parts)) for b in range(a)])
    distance = stack.separation(stack, pairs).distance
    assert distance.min() > -1e-9
    assert set(pairs[distance < 1e-9].ravel()) == set(range(len(parts)))


@pytest.mark.parametrize(("plan", "published"), [(plans.EPAL1, 25.0), (plans.EPAL2, 35.0), (plans.EPAL3, 30.0)])
def test_the_wood_weighs_about_what_is_published(plan: plans.BlockPallet, published: float) -> None:
    volume = sum(np.prod(part.scale) for part in build(plan, "made", "pallet_wood", "pallet_block").parts)
    assert 553.0 * volume == pytest.approx(published, rel=0.06)


def test_the_base_frame_is_closed_around_the_pallet() -> None:
    parts = build(plans.EPAL2, "made", "pallet_wood", "pallet_block").parts
    base = [part for part in parts if part.T_object_part[2, 3] - part.scale[2] / 2 < -0.081 + 1e-9]
    assert Counter(millimetres(part.scale[:2]) for part in base) == {(145, 1000): 2, (910, 100): 2, (910, 145): 1}


def test_steel_brackets_stand_flush_in_the_long_sides() -> None:
    for plan in (plans.EPAL6, plans.EPAL7):
        steel = [part for part in build(plan, "made", "wood", "block").parts if part.material == "galvanised"]
        plates = [part for part in steel if part.scale[0] > 0.05]
        assert (len(steel), len(plates)) == (18, 6)
        assert {round(abs(p.T_object_part[1, 3]) + p.scale[1] / 2, 9) for p in plates} == {0.3}
        assert min(part.scale.min() for part in steel) == pytest.approx(0.003)


INCH = 0.0254
MODEL = pallet("gma_48x40")
STRINGERS = [part for part in MODEL.parts if part.mesh is not unit_box()]


def test_twelve_boards_and_three_stringers_have_the_published_sizes() -> None:
    boards = [part for part in MODEL.parts if part.mesh is unit_box()]
    assert Counter(tuple(np.round(part.scale / INCH, 6)) for part in boards) == {
        (5.5, 40.0, 0.625): 4,
        (3.5, 40.0, 0.625): 8,
    }
    assert len(STRINGERS) == 3
    assert len({part.mesh for part in STRINGERS}) == 1
    extent = np.ptp(STRINGERS[0].placed().vertices, axis=0) / INCH
    np.testing.assert_allclose(extent, [48.0, 1.375, 3.5])


def test_two_notches_of_9_by_1_5_inch_stand_18_inch_apart() -> None:
    beam = STRINGERS[1].placed()
    bottom = beam.vertices[:, 2].min()
    for x in (-13.5, 13.5):
        T = make_transform(translation=np.array([x * INCH, 0.0, bottom + 0.75 * INCH]))
        assert not reaches_into(beam, T, np.array([9.0, 3.0, 1.5]) * INCH)
        for larger in ([9.1, 3.0, 1.4], [8.9, 3.0, 1.6]):
            assert reaches_into(beam, T, np.array(larger) * INCH)
    assert sorted({round(float(x) / INCH, 6) for x in np.abs(beam.vertices[:, 0])}) == [9.0, 18.0, 24.0]


def test_a_stringer_is_solid_but_for_its_notches() -> None:
    assert volume(STRINGERS[0].mesh) / INCH**3 == pytest.approx(1.375 * (48 * 3.5 - 2 * 9 * 1.5))


def test_bottom_boards_keep_clear_of_the_notches() -> None:
    boards = [part for part in MODEL.parts if part.T_object_part[2, 3] < -0.05]
    x = np.array([part.T_object_part[0, 3] for part in boards]) / INCH
    half = np.array([part.scale[0] for part in boards]) / INCH / 2
    order = np.argsort(x)
    left, right = (x - half)[order], (x + half)[order]
    np.testing.assert_allclose([left[2], right[2]], [-1.75, 1.75])
    for low, high in ((-18.0, -9.0), (9.0, 18.0)):
        assert np.all((right <= low + 1e-9) | (left >= high - 1e-9))


def test_physics_leaves_the_notches_open() -> None:
    assert len(MODEL.collision) == 1 + 3 * 4 + 5
    filled = sum(float(np.prod(box.size)) for box in MODEL.collision[1:13])
    assert filled / INCH**3 == pytest.approx(3 * 1.375 * (48 * 3.5 - 2 * 9 * 1.5))
