import numpy as np
import pytest

from tests.generation.occlusion.scenes import box_of, hall, occluded_scene_of, sight_of
from warehouse_sim.generation.occlusion.occluded_scene import fraction_behind
from warehouse_sim.generation.occlusion.occluder import OccluderSampler
from warehouse_sim.generation.occlusion.standing import find_standing_pose, needed_height, slide
from warehouse_sim.scene.loads.unit_load import UnitLoadConfig


@pytest.mark.parametrize("wanted", np.linspace(0.05, 0.95, 10))
def test_sliding_gives_any_fraction_between_the_ends(wanted: float) -> None:
    offset = slide(lambda t: t**2 / 9.0, 3.0, wanted, 0.005)
    assert offset is not None
    assert offset**2 / 9.0 == pytest.approx(wanted, abs=0.005)


def test_sliding_gives_up_where_the_fraction_is_out_of_reach() -> None:
    assert slide(lambda t: 0.4 + t / 10, 1.0, 0.2, 0.01) is None  # even in the middle too much is seen
    assert slide(lambda t: t / 10, 1.0, 0.5, 0.01) is None  # even at the end too little
    assert slide(lambda t: float(t > 0.5), 1.0, 0.5, 0.01) is None  # it jumps


@pytest.mark.parametrize("kind", ["load", "wrap", "pallet", "traffic"])
@pytest.mark.parametrize("wanted", [0.15, 0.5, 0.85])
def test_occluders_of_each_kind_leave_any_fraction(kind: str, wanted: float) -> None:
    rng = np.random.default_rng([3, round(100 * wanted)])
    occluded = occluded_scene_of(hall())
    sight, sampler = sight_of(occluded), OccluderSampler(UnitLoadConfig(), rng)
    for _ in range(8):
        occluder = sampler.sample(kind, needed_height(sight, 0.07))
        T = None if occluder is None else find_standing_pose(occluded, sight, occluder, wanted, 0.02, rng)
        if occluder is not None and T is not None:
            break
    else:
        pytest.fail("nothing fitted")
    assert fraction_behind(sight, occluder, T) == pytest.approx(wanted, abs=0.02)
    box = box_of(occluder, T)
    assert abs(box.corners()[:, 2].min()) < 0.002
    assert occluded.takes(box, 0.05)
    # What was predicted is what is seen once it stands there.
    occluded.add(occluder, T)
    assert sight_of(occluded).fraction == pytest.approx(wanted, abs=0.02)


def test_nothing_is_put_where_there_is_no_room() -> None:
    rng = np.random.default_rng(0)
    blocked = [("drum_steel_216_blue", x, y) for x in np.arange(-3.0, 3.1, 0.7) for y in (-3.2, -2.4, -1.6, -0.9)]
    occluded = occluded_scene_of(hall(*blocked, loose=False))
    sight = sight_of(occluded_scene_of(hall()))
    occluder = OccluderSampler(UnitLoadConfig(), rng).sample("load", 0.4)
    assert occluder is not None
    assert find_standing_pose(occluded, sight, occluder, 0.5, 0.05, rng) is None


def test_a_high_target_seen_from_high_up_needs_a_high_occluder() -> None:
    sight = sight_of(occluded_scene_of(hall()))
    assert needed_height(sight, 0.07) == pytest.approx(1.4 + 0.9 * (0.07 - 1.4))
    assert needed_height(sight, 3.0) == pytest.approx(1.4 + 0.3 * 1.6)
