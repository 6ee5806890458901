import numpy as np
import pytest

from tests.scene.raster import Pile, may_carry
from warehouse_sim.catalog import catalog_object
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import sample_settled_scene
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.physics import crush_state
from warehouse_sim.physics.weights import weights_of
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.schema import SceneSpec

SOLID, FRAGILE, LIGHT = "carton_600x400x300", "carton_600x400x350", "carton_600x400x400"


class Heap:
    """Pieces put on each other by hand."""

    def __init__(self) -> None:
        self.draft = SceneDraft()

    def put(self, name: str, x: float, y: float, z: float, group: int = 1) -> float:
        """Add a piece with the middle of its base at x, y, z (m) and return the height of its top (m)."""
        tall = float(catalog_object(name).size[2])
        self.draft.add(name, make_transform(translation=np.array([x, y, z + tall / 2])), group)
        return z + tall

    def layer(self, name: str, z: float, group: int, count: int = 4) -> float:
        """Add up to four 600 x 400 mm pieces that fill a EUR pallet."""
        places = [(x, y) for x in (-0.3, 0.3) for y in (-0.2, 0.2)]
        return max(self.put(name, x, y, z, group) for x, y in places[:count])

    def kinds(self) -> list[str]:
        """Return the kinds of faults found."""
        scene = SceneSpec(0, 0, self.draft.models, {}, tuple(self.draft.instances), (), (), ("pallet",))
        return sorted({fault.kind for fault in crush_state(scene).faults})


def test_a_tower_of_equal_cartons_breaks_nothing_until_it_is_too_high() -> None:
    model = catalog_object(SOLID)
    high = 1 + int(may_carry(model, False) / model.mass)
    for count, expected in ((high, []), (high + 1, ["overload"])):
        heap, z = Heap(), 0.0
        for _ in range(count):
            z = heap.put(SOLID, 0.0, 0.0, z)
        assert heap.kinds() == expected


def test_fragile_goods_carry_nothing() -> None:
    heap = Heap()
    heap.put("carton_300x200x150", 0.0, 0.0, heap.put(FRAGILE, 0.0, 0.0, 0.0))
    assert heap.kinds() == ["overload"]


def test_a_heavier_piece_stands_below() -> None:
    light, heavy = sorted((SOLID, LIGHT), key=lambda name: catalog_object(name).mass)
    assert catalog_object(heavy).mass > 1.05 * catalog_object(light).mass
    heap = Heap()
    heap.put(light, 0.0, 0.0, heap.put(heavy, 0.0, 0.0, 0.0))
    assert heap.kinds() == []
    heap = Heap()
    heap.put(heavy, 0.0, 0.0, heap.put(light, 0.0, 0.0, 0.0))
    assert heap.kinds() == ["heavy on light"]


def test_sacks_do_not_stand_under_drums() -> None:
    heap = Heap()
    z = heap.put("epal1", 0.0, 0.0, 0.0)
    for _ in range(5):
        z = heap.layer("sack_paper_600x400x110", z, 1)
    heap.put("drum_plastic_60_blue", 0.0, 0.0, heap.put("epal1", 0.0, 0.0, z, 2), 2)
    assert heap.kinds() == ["heavy on light"]


@pytest.mark.parametrize(("count", "expected"), [(4, []), (3, ["layer not full"])])
def test_a_load_needs_most_of_a_layer(count: int, expected: list[str]) -> None:
    heap = Heap()
    z = heap.layer(SOLID, heap.put("epal1", 0.0, 0.0, 0.0), 1, count)
    heap.put("epal1", 0.0, 0.0, z, 2)
    assert heap.kinds() == expected


def test_three_loads_on_each_other_are_wrapped() -> None:
    for film, expected in ((False, ["not secured"]), (True, [])):
        heap, z = Heap(), 0.0
        for group in (1, 2, 3):
            z = heap.layer(LIGHT, heap.put("epal1", 0.0, 0.0, z, group), group)
            if film:
                heap.draft.add("wrap_1200x800x1000", make_transform(), group)
        assert heap.kinds() == expected


def test_a_shipped_scene_keeps_the_rule_and_a_grid_of_points_finds_the_same_weights() -> None:
    sampled = sample_settled_scene(load_recipe("block_storage"), 5, 0)
    assert crush_state(sampled.scene, sampled.report.struck).faults == ()
    weights = weights_of(sampled.scene, frozenset(sampled.report.struck))
    loose = [item for item in sampled.scene.instances if item.dynamic and item.group not in sampled.report.struck]
    pile = Pile(sampled.scene.models, loose)
    by_points = dict(zip((item.instance_id for item in pile.items), pile.carried(), strict=True))
    grounded = [item.instance_id for item in pile.items if item.T_world_object[2, 3] < 0.15]
    assert grounded
    for number in grounded:
        assert weights.carried[number] == pytest.approx(by_points[number], abs=0.5)
