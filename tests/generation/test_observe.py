"""Any sensor of a rig reads the same moment; what is read depends on the moment alone."""

from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

import numpy as np
import pytest

from warehouse_sim.errors import ConfigError, WarehouseSimError
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.recipe.paired_variants import Variant, base_variant
from warehouse_sim.generation.scene import prepare_scene, sample_settled_scene
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.render.renderer import Renderer
from warehouse_sim.schema import ChannelReading, Observation, SceneSpec
from warehouse_sim.sensors.rgbd import RgbdConfig
from warehouse_sim.sensors.rgbd.color import IDEAL_COLOR
from warehouse_sim.sensors.rgbd.depth.model import IdealDepth
from warehouse_sim.sensors.rig import CameraConfig, FurtherSensor, Mount, RigConfig, SensorChoice
from warehouse_sim.sensors.stereo import StereoCamera, StereoConfig
from warehouse_sim.sensors.view import SensorView

pytestmark = pytest.mark.gl


@dataclass(frozen=True)
@ranged
class Ranger:
    """Distances ahead, spread over a fan: neither camera nor LiDAR."""

    reads_light: ClassVar[bool] = False

    beams: Annotated[int, Range(1, 64)] = 8
    """Beams, 1-64."""

    def read(self, view: SensorView, rng: np.random.Generator) -> ChannelReading:
        angle = np.linspace(-0.3, 0.3, self.beams)
        ahead = np.stack([np.cos(angle), np.sin(angle), np.zeros(self.beams)], axis=1)
        T = view.T_world_sensor
        hits = view.caster.cast(np.tile(T[:3, 3], (self.beams, 1)), ahead @ T[:3, :3].T)
        points = hits.distance[:, None] * ahead
        return ChannelReading({"points": points, "noise": rng.random(2), "seen": np.array(list(view.readings), "S8")})


RING = FurtherSensor("ranger", Ranger(), Mount(forward=0.1, yaw_deg=5.0))
IDEAL = RgbdConfig(IdealDepth(min_range=0.01, max_range=400.0), IDEAL_COLOR)


def rig_of_smoke() -> RigConfig:
    """Return the recipe's rig with a camera of half as many pixels each way."""
    return replace(load_recipe("smoke").sensors, camera=CameraConfig(width=612, height=185, focal_px=360.0))


@pytest.fixture(scope="module")
def scene() -> SceneSpec:
    return sample_settled_scene(load_recipe("smoke"), 0, 0).scene


def same(a: Observation, b: Observation) -> None:
    assert a.readings.keys() == b.readings.keys()
    for name, item in a.readings.items():
        for key, values in item.reading.channels.items():
            assert np.array_equal(values, b.readings[name].reading.channels[key]), (name, key)
    assert np.array_equal(a.buffers.rgb, b.buffers.rgb)
    assert [item.illuminance for item in a.annotations] == [item.illuminance for item in b.annotations]
    assert [item.hidden_by for item in a.annotations] == [item.hidden_by for item in b.annotations]
    assert a.conditions == b.conditions


def test_a_sensor_of_another_kind_reads_at_its_own_place_and_disturbs_no_other(
    scene: SceneSpec, renderer: Renderer
) -> None:
    rig = rig_of_smoke()
    alone = list(observe_scene(scene, rig, renderer))
    for first, seen in zip(alone, observe_scene(scene, replace(rig, more={"ring": RING}), renderer), strict=True):
        ring = seen.readings["ring"]
        assert list(ring.reading.channels["seen"]) == [b"camera", b"lidar", b"imu"]
        points = transform_points(ring.T_camera_sensor, ring.reading.channels["points"])
        u, v = np.rint(seen.camera.project(points)).astype(int).T
        inside = (u >= 0) & (u < seen.camera.width) & (v >= 0) & (v < seen.camera.height)
        # The camera stands 0.1 m behind: most of what the ranger met, it sees at the same depth.
        depth = seen.buffers.depth[v[inside], u[inside]]
        assert np.median(np.abs(depth - points[inside, 2])) < 0.01
        same(first, seen.with_reading("ring", None))


def test_the_rays_of_the_preparation_are_taken_whatever_the_light_has_become(
    renderer: Renderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    prepared, rig = prepare_scene(load_recipe("smoke"), 0, 0), rig_of_smoke()
    own = list(observe_scene(prepared.scene, rig, renderer))
    monkeypatch.delattr("warehouse_sim.generation.observe.RayCaster")
    given = observe_scene(prepared.scene, rig, renderer, caster=prepared.caster)
    for one, other in zip(own, given, strict=True):
        same(one, other)


def test_a_further_camera_sees_what_the_second_of_a_pair_sees_from_the_same_place(
    scene: SceneSpec, renderer: Renderer
) -> None:
    low = FurtherSensor("rgbd", IDEAL, Mount(left=-0.3))
    rig = replace(rig_of_smoke(), right=StereoConfig(baseline=0.3, matching=None), more={"low": low})
    seen = next(observe_scene(scene, rig, renderer))
    assert seen.stereo is not None
    channels = seen.readings["low"].reading.channels
    assert np.array_equal(channels["rgb"], seen.stereo.buffers.rgb)
    assert np.array_equal(channels["depth"], seen.stereo.buffers.depth)
    assert not np.array_equal(channels["rgb"], seen.buffers.rgb)


@dataclass(frozen=True)
class Mute:
    """Reads a bare array."""

    def read(self, view: SensorView, rng: np.random.Generator) -> np.ndarray:
        return np.zeros(3)


def test_what_is_no_reading_is_rejected_in_one_line(scene: SceneSpec, renderer: Renderer) -> None:
    rig = replace(rig_of_smoke(), more={"mute": FurtherSensor("mute_one", Mute())})  # type: ignore[arg-type]
    with pytest.raises(WarehouseSimError, match=r"mute \(mute_one\) gave ndarray, which is no reading"):
        next(observe_scene(scene, rig, renderer))


def test_a_pair_that_is_mounted_askew_is_rejected(scene: SceneSpec, renderer: Renderer) -> None:
    pair = FurtherSensor("stereo", StereoCamera(StereoConfig(baseline=0.3)), Mount(left=-0.2))
    with pytest.raises(ConfigError, match=r"a stereo camera of baseline 0\.3 m sits .* mount it with left: -0\.3"):
        next(observe_scene(scene, replace(rig_of_smoke(), more={"pair": pair}), renderer))


def test_a_paired_variant_depends_on_no_other_paired_variant_nor_on_the_call_before(
    scene: SceneSpec, renderer: Renderer
) -> None:
    rig = replace(rig_of_smoke(), more={"ring": RING})
    scene = replace(scene, viewpoints=scene.viewpoints[:1])
    base = base_variant(scene, SensorChoice("", rig.rgbd))
    lights = tuple(replace(light, intensity=light.intensity * 0.5) for light in scene.lights)
    dim = Variant("dim", replace(scene, lights=lights), base.sensor)
    rough = replace(scene.materials["kraft"], roughness=0.2, remission=0.9)
    shiny = Variant("shiny", replace(scene, materials=scene.materials | {"kraft": rough}), base.sensor)
    again = Variant("again", scene, base.sensor, noise_sample=1)
    all_at_once = list(observe_scene(scene, rig, renderer, (base, dim, shiny, again)))
    count = len(scene.viewpoints)
    for place, paired_variant in ((1, dim), (2, shiny), (3, again)):
        pair = list(observe_scene(scene, rig, renderer, (base, paired_variant)))
        for index in range(count):
            same(pair[count + index], all_at_once[place * count + index])
    # Nor on what it is a paired variant of, if it is observed alone.
    for index, single in enumerate(observe_scene(dim.scene, rig, renderer, (dim,))):
        variant_group = replace(single.conditions, variant_group=index)
        same(replace(single, conditions=variant_group), all_at_once[count + index])
    assert all_at_once[0].readings["ring"] is all_at_once[count].readings["ring"]
