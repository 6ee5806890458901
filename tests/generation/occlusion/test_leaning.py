import numpy as np

from tests.generation.occlusion.scenes import box_of, hall, occluded_scene_of, sight_of
from warehouse_sim.catalog import catalog_object
from warehouse_sim.generation.occlusion.leaning import find_leaning_pose, leaning_pallet
from warehouse_sim.generation.occlusion.occluded_scene import fraction_behind
from warehouse_sim.generation.occlusion.occluder import Occluder
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.schema import ObjectInstance

PALLET = leaning_pallet(catalog_object("epal1"))


def upright(x: float, y: float, z: float = 0.0) -> Transform:
    return make_transform(translation=np.array([x, y, z]))


def leaned(*things: tuple[str, float, float], wanted: float = 0.4, tolerance: float = 0.3) -> Transform | None:
    occluded = occluded_scene_of(hall(*things))
    return find_leaning_pose(occluded, sight_of(occluded), PALLET, 0.5, wanted, tolerance, np.random.default_rng(0))


def test_a_pallet_leans_against_what_stands_beside_the_target() -> None:
    things = (("drum_steel_216_blue", -0.95, -0.2), ("drum_steel_216_blue", 0.95, -0.2))
    T = leaned(*things)
    assert T is not None
    occluded = occluded_scene_of(hall(*things))
    box = box_of(PALLET, T)
    corners = box.corners()
    assert abs(corners[:, 2].min()) < 0.002  # on the floor
    assert corners[:, 2].max() > 0.7  # on its edge
    assert -0.003 < occluded.solids.gap(box, 0.1) < 0.003  # in contact, not inside
    lean = np.degrees(np.arcsin(abs(T[2, 2])))
    assert 8.0 < lean < 17.0
    # Its upper edge is ahead of its lower one.
    assert corners[corners[:, 2] > 0.5][:, 1].mean() > corners[corners[:, 2] < 0.3][:, 1].mean() + 0.08
    assert abs(fraction_behind(sight_of(occluded), PALLET, T) - 0.4) < 0.3


def test_nothing_leans_on_what_another_request_put_there() -> None:
    """A paired variant without that would leave it in the air."""
    drum = catalog_object("drum_steel_216_blue")
    occluder = Occluder("drum", {drum.name: drum}, (ObjectInstance(1, drum.name, upright(0.0, 0.0, drum.size[2] / 2)),))
    occluded = occluded_scene_of(hall())
    for x in (-0.95, 0.95):
        occluded.add(occluder, upright(x, -0.2))
    sight = sight_of(occluded)
    assert find_leaning_pose(occluded, sight, PALLET, 0.5, 0.4, 0.3, np.random.default_rng(0)) is None


def test_nothing_leans_in_the_open_or_against_something_low() -> None:
    assert leaned() is None  # the target itself is too low
    assert leaned(("cone_500", 0.0, -1.0)) is None
