"""Pallets of any shape keep what pallets of the catalog keep: pockets that are empty, solids that leave them open."""

from dataclasses import replace

import numpy as np
import pytest

from tests.catalog.pallets.touching import hits, is_closed, prism_of, same_points
from warehouse_sim.catalog.pallets.parametric import PalletShape, parametric_pallet
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.physics import settle_scene
from warehouse_sim.scene import sample_scene
from warehouse_sim.scene.packing.load_config import SampledPalletsConfig, sampled_pallets
from warehouse_sim.schema import ObjectModel

FEW = sampled_pallets(SampledPalletsConfig(count=24, seed=3))
FAMILY = sampled_pallets(load_recipe("robust_pallets").scene.loads.sampled_pallets)
"""What estimators are trained on: far from any standard."""
SAMPLED = (*FEW, *FAMILY)
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
