import numpy as np
import pytest

from tests.scene.raster import Pile, may_carry
from warehouse_sim.catalog import catalog_object
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import sample_settled_scene
from warehouse_sim.geometry.convex import area, centroid, shared
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.physics import crush_state
from warehouse_sim.physics.weights import _second_moments, weights_of
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
    few = {"scene": {"layout": {"lanes": 4, "lane_depth": 3}, "observations_per_scene": 1}}
    sampled = sample_settled_scene(load_recipe("block_storage", few), 5, 0)
    assert crush_state(sampled.scene, sampled.report.struck).faults == ()
    weights = weights_of(sampled.scene, frozenset(sampled.report.struck))
    loose = [item for item in sampled.scene.instances if item.dynamic and item.group not in sampled.report.struck]
    pile = Pile(sampled.scene.models, loose)
    by_points = dict(zip((item.instance_id for item in pile.items), pile.carried(), strict=True))
    grounded = [item.instance_id for item in pile.items if item.T_world_object[2, 3] < 0.15]
    assert grounded
    for number in grounded:
        assert weights.carried[number] == pytest.approx(by_points[number], abs=0.5)


CARTON = "carton_600x400x300"


def scene_of(*pieces: tuple[str, float, float, float]) -> SceneSpec:
    """Return a scene of loose pieces by catalog name and the middle of their base (m), all in one load."""
    draft = SceneDraft()
    for name, x, y, z in pieces:
        half = catalog_object(name).size[2] / 2
        draft.add(name, make_transform(translation=np.array([x, y, z + half])), 1)
    return SceneSpec(0, 0, draft.models, {}, tuple(draft.instances), (), (), ("pallet",))


def test_two_outlines_share_what_a_grid_of_points_finds_in_both() -> None:
    rng = np.random.default_rng(3)
    square = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    turned = square @ rotation_z(0.5)[:2, :2].T + [0.3, 0.1]
    points = rng.uniform(-1.0, 1.0, (200_000, 2))
    inside = np.all(np.abs(points) < 0.5, axis=1)
    inside &= np.all(np.abs((points - [0.3, 0.1]) @ rotation_z(0.5)[:2, :2]) < 0.5, axis=1)
    common = shared(square, turned)
    assert area(common) == pytest.approx(4.0 * inside.mean(), rel=0.02)
    np.testing.assert_allclose(centroid(common), points[inside].mean(axis=0), atol=0.01)
    assert len(shared(square, turned + np.array([2.0, 0.0]))) == 0


def test_a_beam_on_two_supports_presses_by_the_law_of_the_lever() -> None:
    low = catalog_object(CARTON).size[2]
    scene = scene_of((CARTON, -0.50, 0.0, 0.0), (CARTON, 0.55, 0.0, 0.0), (CARTON, 0.0, 0.0, low))
    carried = weights_of(scene).carried
    mass = catalog_object(CARTON).mass
    # The patches reach over 0.10 and 0.05 m: their middles are 0.25 m to the left and 0.275 m to the right.
    assert carried[1] == pytest.approx(mass * 0.275 / 0.525, rel=0.02)
    assert carried[1] + carried[2] == pytest.approx(mass)
    assert carried[3] == 0.0


def test_weight_off_the_middle_presses_on_the_near_side() -> None:
    low = catalog_object(CARTON).size[2]
    base = [(CARTON, x, 0.0, 0.0) for x in (-0.302, 0.302)]
    board = ("epal1", 0.0, 0.0, low)
    top = low + catalog_object("epal1").size[2]
    carried = weights_of(scene_of(*base, board, ("carton_400x300x300", 0.35, 0.0, top))).carried
    assert carried[2] > 1.2 * carried[1] > 0.0
    total = catalog_object("epal1").mass + catalog_object("carton_400x300x300").mass
    assert carried[1] + carried[2] == pytest.approx(total)


def test_a_column_adds_up_and_what_leans_is_left_out() -> None:
    model = catalog_object(CARTON)
    pieces = [(CARTON, 0.0, 0.0, level * model.size[2]) for level in range(4)]
    carried = weights_of(scene_of(*pieces)).carried
    assert [carried[i] for i in (1, 2, 3, 4)] == pytest.approx([3 * model.mass, 2 * model.mass, model.mass, 0.0])
    draft = SceneDraft()
    c = np.cos(0.2)
    tilted = np.array([[c, 0, np.sin(0.2)], [0, 1, 0], [-np.sin(0.2), 0, c]])
    draft.add(CARTON, make_transform(tilted, np.array([0.0, 0.0, 1.0])), 1)
    scene = SceneSpec(0, 0, draft.models, {}, tuple(draft.instances), (), (), ("pallet",))
    assert weights_of(scene).carried == {}


def test_second_moments_of_a_patch_are_those_of_its_shape() -> None:
    w, h = 0.3, 0.1
    rectangle = np.array([[1.0, 2.0], [1.0 + w, 2.0], [1.0 + w, 2.0 + h], [1.0, 2.0 + h]])
    # About the centroid: w^3 h / 12 along x; of a right triangle w^3 h / 36, with w^2 h^2 / 72 between its axes.
    np.testing.assert_allclose(_second_moments(rectangle), np.diag([w**3 * h, w * h**3]) / 12.0, rtol=1e-9, atol=1e-12)
    triangle = np.array([[0.0, 0.0], [w, 0.0], [0.0, h]])
    expected = np.array([[w**3 * h / 36, -(w**2) * h**2 / 72], [-(w**2) * h**2 / 72, w * h**3 / 36]])
    np.testing.assert_allclose(_second_moments(triangle), expected, rtol=1e-9, atol=1e-12)
