"""Goods without a pallet: they stand on shelves and conveyors, keep their class, can be targets and touch nothing."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from warehouse_sim.errors import ConfigError
from warehouse_sim.physics.check import contact_state
from warehouse_sim.scene import SceneRecipe, sample_scene
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.loads.backdrop import is_backdrop
from warehouse_sim.scene.loads.resting import drop_to_rest
from warehouse_sim.scene.loads.shelving import ShelvingConfig
from warehouse_sim.scene.loads.staging import StagingConfig
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import ObjectInstance, SceneSpec

CRATE = """
name: bottle_crate
class_name: crate
obj_id: 1010
file: crate.obj
mass: 14
material: plastic_red
"""


@pytest.fixture
def crate(tmp_path: Path) -> Path:
    """A crate of 400 x 300 x 250 mm as a user brings it."""
    corners = [(x, y, z) for z in (0.0, 0.25) for x, y in ((0.0, 0.0), (0.4, 0.0), (0.4, 0.3), (0.0, 0.3))]
    faces = ("4 3 2 1", "5 6 7 8", "1 2 6 5", "2 3 7 6", "3 4 8 7", "4 1 5 8")
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {face}" for face in faces]
    (tmp_path / "crate.obj").write_text("\n".join(lines), encoding="utf-8")
    path = tmp_path / "crate.yaml"
    path.write_text(CRATE, encoding="utf-8")
    return path


def recipe(layout: dict[str, Any], crate: Path, **more: Any) -> SceneRecipe:
    """A small scene with that layout, in which the crate is a target."""
    plain = {
        "layout": layout,
        "loads": {"goods": [str(crate)]},
        "staging": {"count": 0},
        "observations_per_scene": 1,
        "targets": ["pallet", "crate"],
        "viewpoints": {"aisle_fraction": 0.0, "distance": {"min": 1.5, "max": 8.0}, "height": {"min": 0.6, "max": 1.6}},
    }
    return SceneRecipe.from_plain(plain | more, "test")


def crates(scene: SceneSpec) -> Sequence[ObjectInstance]:
    return [item for item in scene.instances if scene.model_of(item).class_name == "crate"]


LAYOUTS: dict[str, dict[str, Any]] = {
    "small_parts": {"kind": "small_parts", "bays": 4, "rows": 2, "goods_fraction": 0.5},
    "mezzanine": {
        "kind": "mixed",
        "front": {"kind": "mezzanine", "panels": 3, "goods_fraction": 0.3},
        "back": {"kind": "rack_aisle", "bays": 2},
    },
    "conveyor": {
        "kind": "mixed",
        "front": {"kind": "conveyor_pickup", "segments": 4, "carton_fill": 0.8, "goods_fraction": 0.5},
        "back": {"kind": "rack_aisle", "bays": 2},
    },
}


@pytest.mark.parametrize("name", LAYOUTS)
def test_goods_of_the_users_own_rest_on_bare_surfaces_and_touch_nothing(name: str, crate: Path) -> None:
    scene = sample_scene(recipe(LAYOUTS[name], crate), seed=3, scene_index=0)
    found = crates(scene)
    assert len(found) >= 5
    assert {item.instance_id for item in found} <= {item.instance_id for item in scene.target_instances()}
    solids = Solids.of(scene.instances, scene.models)
    for item in found:
        assert not item.dynamic
        mine = solids.of_objects([item.instance_id])
        near = solids.near(*solids.extent_of([item.instance_id]), 0.05) & ~mine
        assert drop_to_rest(solids.boxes.subset(mine), solids.boxes.subset(near)) == pytest.approx(0.0, abs=1e-9)
    alone = solids.boxes.subset(solids.of_objects([item.instance_id for item in found]))
    pairs = alone.pairs(solids.boxes, 0.0)
    own = solids.owner[solids.of_objects([item.instance_id for item in found])]
    pairs = pairs[own[pairs[:, 0]] != solids.owner[pairs[:, 1]]]
    assert (alone.separation(solids.boxes, pairs).distance > -1e-6).all()


def test_cartons_stand_on_the_carton_line_beside_them(crate: Path) -> None:
    scene = sample_scene(recipe(LAYOUTS["conveyor"], crate), seed=3, scene_index=0)
    line = [
        item
        for item in scene.instances
        if scene.model_of(item).class_name == "carton" and not item.dynamic and item.group == 0
    ]
    bottoms = [item.T_world_object[2, 3] - scene.model_of(item).size[2] / 2 for item in line]
    np.testing.assert_allclose(bottoms, 0.75, atol=1e-9)
    assert len(line) >= 2


def test_shelves_kept_for_goods_need_goods() -> None:
    with pytest.raises(ConfigError, match=r"layout\.goods_fraction needs articles; list them under loads\.goods"):
        SceneRecipe.from_plain({"layout": {"kind": "small_parts", "goods_fraction": 0.2}}, "test")


def test_without_a_share_nothing_else_is_drawn(crate: Path) -> None:
    layout = {"kind": "small_parts", "bays": 3}
    loads = {"loads": {}, "targets": ["pallet"], "staging": {"count": 2}}
    plain, own = (
        sample_scene(recipe(layout, crate, **(loads | more)), 3, 0) for more in ({}, {"loads": {"goods": [str(crate)]}})
    )
    assert [item.model for item in plain.instances] == [item.model for item in own.instances]


# Loads in racks that nothing reaches: fixed, shared, and at rest without any simulation.


def scene(targets: tuple[str, ...] = ("pallet",)) -> SceneSpec:
    layout = RackAisleConfig(bays=3, rows_behind=2, sides="both", aisle_width=4.0)
    recipe = SceneRecipe(
        layout=layout,
        shelving=ShelvingConfig(empty_slot_fraction=0.1),
        staging=StagingConfig(count=Distribution.constant(0)),
        targets=targets,
        observations_per_scene=2,
    )
    return sample_scene(recipe, seed=3, scene_index=0)


@pytest.mark.parametrize("targets", [("pallet",), ("pallet", "carton")])
def test_it_rests_and_overlaps_nothing(targets: tuple[str, ...]) -> None:
    sampled = scene(targets)
    # The check looks at what is loose: for its sake what is fixed there is loose, and the rest is gone.
    parts = [item for item in sampled.instances if not item.dynamic]
    fixed = [replace(item, dynamic=is_backdrop(item)) for item in parts]
    state = contact_state(replace(sampled, instances=tuple(fixed), viewpoints=()))
    assert state.loose.size > 100
    assert state.max_overlap < 1e-6
    assert state.max_gap < 1e-6


def test_pallets_there_are_labelled_and_not_aimed_at() -> None:
    sampled = scene()
    fixed = {item.instance_id for item in sampled.instances if is_backdrop(item)}
    labelled = {item.instance_id for item in sampled.target_instances()}
    assert len(fixed & labelled) > 40
    assert not {view.target for view in sampled.viewpoints} & fixed


def test_goods_are_one_object_a_load_unless_they_are_targets() -> None:
    whole, apart = scene(), scene(("pallet", "carton"))

    def count(sampled: SceneSpec, kind: str) -> int:
        return sum(is_backdrop(item) and sampled.model_of(item).class_name == kind for item in sampled.instances)

    assert (count(whole, "carton"), count(apart, "goods")) == (0, 0)
    assert 0 < count(whole, "goods") <= count(whole, "pallet")
    assert count(apart, "carton") > count(whole, "goods")
    for name, model in whole.models.items():
        if model.class_name == "goods":
            extent = np.ptp(model.mesh().vertices, axis=0)
            assert np.all((extent <= model.size + 1e-9) & (extent > model.size - 0.003)), name
