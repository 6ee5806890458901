"""Second returns, and what shines beside a retroreflector."""

from dataclasses import replace

import numpy as np

from tests.sensors.lidar.test_footprint import plate_and_wall
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import LidarScan, Material
from warehouse_sim.sensors.lidar import LidarConfig, scan
from warehouse_sim.sensors.lidar.echo import Echoes, PulseEchoes

QUIET = replace(LidarConfig().ideal(), divergence_mrad=(2.0, 2.0), azimuth_range_deg=(-20.0, 20.0))


def read(raycaster: RayCaster, config: LidarConfig) -> LidarScan:
    return scan(raycaster, config, at(0, 0, 0), np.random.default_rng(0))


def test_an_edge_before_a_wall_gives_two_returns_of_one_pulse() -> None:
    raycaster = plate_and_wall(2.0)
    strongest, last, dual = (read(raycaster, replace(QUIET, returns=which)) for which in ("strongest", "last", "dual"))
    assert len(strongest.points) == len(last.points) < len(dual.points)
    same = (dual.ring[1:] == dual.ring[:-1]) & (dual.time[1:] == dual.time[:-1])
    pairs = np.flatnonzero(same)
    assert len(pairs) == len(dual.points) - len(strongest.points) > 10
    apart = np.abs(dual.points[pairs + 1, 0] - dual.points[pairs, 0])
    np.testing.assert_allclose(apart, 2.0, atol=0.01)
    assert {*dual.instance_ids[pairs].tolist(), *dual.instance_ids[pairs + 1].tolist()} == {1, 2}
    assert (np.diff(dual.time) >= 0).all()
    # The first of each pulse is what a strongest return reports; where they differ, the last is the wall.
    firsts = np.delete(np.arange(len(dual.points)), pairs + 1)
    np.testing.assert_array_equal(dual.points[firsts], strongest.points)
    differ = np.abs(last.points[:, 0] - strongest.points[:, 0]) > 1e-3
    assert differ.any()
    assert (last.instance_ids[differ] == 2).all()


def test_the_last_and_the_second_strongest_echo_are_picked_by_hand() -> None:
    inf = np.inf
    fractions = Echoes(
        np.float32([[5.0, 10.0, 20.0], [5.0, 10.0, inf], [5.0, 5.2, inf], [inf, inf, inf], [5.0, 10.0, 20.0]]),
        np.float32([[0.5, 0.9, 0.1], [0.01, 0.9, 0.0], [0.4, 0.4, 0.0], [0.0, 0.0, 0.0], [0.01, 0.1, 9.0]]),
        np.int32([[1, 2, 3], [1, 2, 0], [1, 2, 0], [0, 0, 0], [1, 2, 3]]),
    )
    pulses = PulseEchoes.of(fractions, pulse_length=0.75, extinction=0.0)
    assert pulses.pick("strongest").instance_ids.tolist() == [1, 2, 1, 0, 3]
    last = pulses.pick("last")
    assert last.instance_ids.tolist() == [3, 2, 1, 0, 3]
    np.testing.assert_allclose(last.distance[[0, 1]], [20.0, 10.0])
    other = pulses.pick("other")
    assert other.instance_ids.tolist() == [3, 1, 0, 0, 2]
    np.testing.assert_allclose(other.distance, [20.0, 5.0, inf, inf, 10.0])
    assert other.reflectance[[2, 3]].tolist() == [0.0, 0.0]


def shining(remission: float) -> RayCaster:
    """A small plate 5 m ahead of a wall at 10 m."""
    materials = {
        "plate": Material("plate", (0.5, 0.5, 0.5), remission=remission),
        "wall": Material("wall", (0.5, 0.5, 0.5), remission=0.3),
    }
    models = [box_model("plate", (0.02, 0.3, 0.3), "plate"), box_model("wall", (1, 80, 80), "wall")]
    return RayCaster(make_scene(models, [("plate", at(5.01, 0, -0.2)), ("wall", at(10.5, 0, 0))], materials=materials))


def test_beams_beside_a_retroreflector_see_it_too() -> None:
    thin = replace(QUIET, divergence_mrad=(0.0, 0.0))
    without, with_bloom = (read(shining(2.0), replace(thin, bloom_deg=degrees)) for degrees in (0.0, 0.4))
    dull = read(shining(0.5), replace(thin, bloom_deg=0.4))
    near = [result.points[result.points[:, 0] < 5.5] for result in (without, with_bloom, dull)]
    assert len(near[0]) == len(near[2])
    assert len(near[1]) > 1.3 * len(near[0])
    # 30 % of remission at 10 m are 7.5 % at 5 m, which is what leaks at 0.2 deg log10(10 / 0.075) = 0.425 deg; lasers
    # start 26 mm beside the axis, 0.3 deg at 5 m, and a beam is 0.17 deg from the next.
    aside = np.degrees(np.arctan2(np.abs(near[1][:, 1]), near[1][:, 0])) - np.degrees(np.arctan2(0.15, 5.0))
    assert 0.25 < aside.max() < 0.425 + 0.3 + 0.17
    halo = with_bloom.points[:, 0] < 5.5
    nameless = with_bloom.instance_ids == 0
    assert (halo[nameless]).all()
    assert nameless.sum() == len(near[1]) - len(near[0])
    assert with_bloom.intensity[nameless].min() < 0.9
