import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from tests.render.pathtracing import open_pathtracer
from warehouse_sim.errors import ConfigError, RenderError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render import Renderer
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene, rack_wall, spot
from warehouse_sim.render.conformance.subject import cast_image
from warehouse_sim.schema import Material, SceneSpec

CAMERA = PinholeCamera.from_focal(320, 200, 190.0)
OFF_CENTRE = PinholeCamera(200, 150, 210.0, 190.0, 61.3, 107.8)


@pytest.fixture(scope="module")
def tracer() -> Iterator[Any]:
    with open_pathtracer(samples=2) as opened:
        yield opened


@pytest.mark.parametrize("camera", [CAMERA, OFF_CENTRE])
def test_every_channel_agrees_with_ray_casting(tracer: Any, wall: SceneSpec, camera: PinholeCamera) -> None:
    tracer.load(wall)
    for viewpoint in wall.viewpoints[:2]:
        buffers = tracer.render(camera, viewpoint.T_world_camera, normals=True)
        gt = cast_image(wall, camera, viewpoint.T_world_camera)
        assert (buffers.instance_mask == gt.instance_mask).mean() >= 0.9999
        same = (buffers.instance_mask == gt.instance_mask) & (gt.instance_mask > 0) & gt.inside()
        assert np.count_nonzero(same) > 3000
        assert np.abs(buffers.depth - gt.depth)[same].max() < 2e-4
        assert ((buffers.normals * gt.normals).sum(axis=-1)[same] > 0.999999).all()
        nothing = buffers.instance_mask == 0
        assert (buffers.normals[nothing] == 0.0).all()
        assert np.array_equal(buffers.depth == 0.0, nothing)
        assert tracer.render(camera, viewpoint.T_world_camera).normals is None


def test_colours_lie_where_ids_lie() -> None:
    """A glowing box in the dark: it covers more than half of the pixels whose centre it covers, and of no other."""
    paint = {**MATERIALS, "kraft": Material("kraft", (1.0, 1.0, 1.0), emission=1.0 / 0.015)}
    view = level_camera(np.array([0.0, 0.0, 1.2]), 0.0, roll=0.1)
    with open_pathtracer(samples=256) as sharp:
        for yaw in (0.4, 1.0, 2.0):
            placed = [("box", at(4, 0.3, 1, yaw))]
            scene = make_scene([box_model("box", (0.9, 0.6, 0.5))], placed, (), (), paint, 0.0)
            sharp.load(scene)
            covered = sharp.luminance(OFF_CENTRE, view)[..., 0] * scene.exposure
            shown = sharp.render(OFF_CENTRE, view).instance_mask > 0
            rim = np.count_nonzero((covered > 0.01) & (covered < 0.99))
            assert rim > 60
            assert np.count_nonzero((covered > 0.5) != shown) < 0.05 * rim
            inner = cv2.erode(shown.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
            np.testing.assert_allclose(covered[inner], 1.0, rtol=1e-5)


def test_amodal_masks_are_the_ids_of_the_object_alone(tracer: Any, wall: SceneSpec) -> None:
    T = wall.viewpoints[2].T_world_camera
    chosen = [wall.instances[k] for k in (3, 20, 30, 41)]
    tracer.load(wall)
    found = tracer.amodal_masks(CAMERA, T, chosen)
    canvas = CAMERA.crop(-CAMERA.width, -CAMERA.height, 3 * CAMERA.width, 3 * CAMERA.height)
    sizes = []
    for instance, amodal_mask in zip(chosen, found, strict=True):
        alone = cast_image(replace(wall, instances=(instance,)), canvas, T).instance_mask > 0
        sampled = np.zeros_like(alone)
        left, top = amodal_mask.offset[0] + CAMERA.width, amodal_mask.offset[1] + CAMERA.height
        height, width = amodal_mask.mask.shape
        sampled[top : top + height, left : left + width] = amodal_mask.mask
        assert np.count_nonzero(sampled != alone) <= max(2, 0.001 * np.count_nonzero(alone))
        sizes.append(int(sampled.sum()))
    assert sum(size > 200 for size in sizes) >= 2


def grain(image: np.ndarray) -> np.ndarray:
    """Return what is between noise and shade in size."""
    return cv2.GaussianBlur(image, (0, 0), 2) - cv2.GaussianBlur(image, (0, 0), 8)


@pytest.mark.gl
@pytest.mark.parametrize("size", [(1.2, 0.5, 0.4), (0.4, 1.2, 0.5)])
def test_the_grain_lies_where_the_raster_backend_puts_it(renderer: Renderer, size: tuple[float, float, float]) -> None:
    paint = {**MATERIALS, "kraft": replace(MATERIALS["kraft"], texture="wood", texture_size=0.5)}
    box = box_model("box", size)
    scene = make_scene([box], [("box", at(0, 0, 0.3, 0.3))], materials=paint, ambient=200.0)
    camera = PinholeCamera.from_focal(200, 160, 300.0)
    patches = {}
    for view, T in {
        "above": level_camera(np.array([0.0, 0.0, 1.9]), 0.3, -np.pi / 2),
        "side": level_camera(np.array([-1.2, -1.2, 0.3]), np.pi / 4),
    }.items():
        renderer.load(scene)
        with open_pathtracer(samples=256) as sharp:
            sharp.load(scene)
            images = [item.render(camera, T) for item in (renderer, sharp)]
        shown = cv2.erode((images[0].instance_mask > 0).astype(np.uint8), np.ones((7, 7), np.uint8)) > 0
        grains = [grain(item.rgb[..., 1].astype(float)) for item in images]
        patches[view] = np.corrcoef(grains[0][shown], grains[1][shown])[0, 1]
    assert min(patches.values()) > 0.8


def test_a_normal_map_bends_light_the_way_the_texture_leans(tracer: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """A board seen from above under a light at +x: brighter where normals lean to +x."""
    from warehouse_sim.render.pathtrace import materials
    from warehouse_sim.render.pathtrace.materials import TextureSet

    paint = {**MATERIALS, "kraft": replace(MATERIALS["kraft"], texture="wood")}
    levels = []
    with open_pathtracer(samples=64) as sharp:
        for u, v in ((0.3, 0.0), (0.0, 0.0), (-0.3, 0.0), (0.0, 0.3), (0.0, -0.3)):
            normal = np.array([u, v, np.sqrt(1.0 - u * u - v * v)], np.float32)
            maps = TextureSet(np.ones((2, 2, 1), np.float32), np.tile((normal + 1) / 2, (2, 2, 1)), None)
            monkeypatch.setattr(materials, "load_texture_set", lambda name, maps=maps: maps)
            light = spot((1.2, 0.0, 1.2), 600.0)
            scene = make_scene([box_model("box", (0.6, 0.4, 0.4))], [("box", at(0, 0, -0.2))], [light], (), paint)
            sharp.load(scene)
            view = level_camera(np.array([0.0, 0.0, 4.0]), 0.0, -np.pi / 2)
            levels.append(sharp.luminance(PinholeCamera.from_focal(4, 4, 400.0), view).mean())
    towards, flat, away, left, right = levels
    assert away < 0.8 * flat < flat < towards
    assert left == pytest.approx(right, rel=0.03)  # v runs across the direction to the light


def test_the_same_seed_gives_the_same_bytes_and_another_does_not(tracer: Any, wall: SceneSpec) -> None:
    T = wall.viewpoints[0].T_world_camera
    tracer.load(wall)
    first = tracer.render(CAMERA, T).rgb
    assert np.array_equal(tracer.render(CAMERA, T).rgb, first)
    for seed, same in ((0, True), (1, False)):
        with open_pathtracer(samples=2, seed=seed) as other:
            other.load(wall)
            assert np.array_equal(other.render(CAMERA, T).rgb, first) == same


def test_the_number_of_threads_changes_no_byte(tracer: Any, wall: SceneSpec) -> None:
    import drjit as dr

    tracer.load(wall)
    T = wall.viewpoints[0].T_world_camera
    many = dr.thread_count()
    images = []
    for count in (1, many):
        dr.set_thread_count(count)
        images.append(tracer.render(CAMERA, T).rgb)
    assert np.array_equal(*images)


def test_more_paths_come_closer_to_the_limit(wall: SceneSpec) -> None:
    T = wall.viewpoints[1].T_world_camera
    camera = PinholeCamera.from_focal(48, 30, 30.0)
    found = []
    for samples, seed in ((4, 1), (64, 2), (1024, 3)):
        with open_pathtracer(samples=samples, seed=seed) as renderer:
            renderer.load(wall)
            found.append(renderer.luminance(camera, T))
    coarse, fine = (np.sqrt(((item - found[2]) ** 2).mean()) for item in found[:2])
    assert fine < 0.4 * coarse  # a quarter in theory


def test_a_scene_that_cannot_be_drawn_says_why_and_leaves_the_one_before(tracer: Any, wall: SceneSpec) -> None:
    tracer.load(wall)
    before = tracer.render(CAMERA, wall.viewpoints[0].T_world_camera).rgb
    with pytest.raises(RenderError, match="nothing to render"):
        tracer.load(replace(wall, instances=()))
    paint = {**wall.materials, "kraft": replace(wall.materials["kraft"], texture="marble")}
    with pytest.raises(RenderError, match="texture 'marble'"):
        tracer.load(replace(wall, materials=paint))
    assert np.array_equal(tracer.render(CAMERA, wall.viewpoints[0].T_world_camera).rgb, before)


def test_use_before_load_and_after_close_is_rejected(wall: SceneSpec) -> None:
    fresh = open_pathtracer()
    T = wall.viewpoints[0].T_world_camera
    with pytest.raises(RenderError, match="no scene is loaded"):
        fresh.render(CAMERA, T)
    fresh.close()
    with pytest.raises(RenderError, match="closed"):
        fresh.load(wall)
    with pytest.raises(ConfigError, match="samples must be 1-1,000,000, found 0"):
        open_pathtracer(samples=0)


def test_a_scene_of_nothing_but_film_is_drawn(tracer: Any) -> None:
    film = Material("film", (0.8, 0.8, 0.8), opacity=0.5)
    scene = make_scene(
        [box_model("film", (1, 1, 1), "film")], [("film", at(3, 0, 0))], [spot((0, 0, 4))], (), {"film": film}
    )
    tracer.load(scene)
    buffers = tracer.render(CAMERA, level_camera(np.zeros(3), 0.0), normals=True)
    assert not buffers.instance_mask.any()
    assert buffers.rgb[100, 160].max() > 0
    assert tracer.amodal_masks(CAMERA, level_camera(np.zeros(3), 0.0), scene.instances)[0].mask.size == 0


def test_importing_the_backends_registry_loads_no_mitsuba() -> None:
    script = "import sys, warehouse_sim.render; sys.exit('mitsuba' in sys.modules)"
    root = Path(__file__).resolve().parents[2]
    assert subprocess.run([sys.executable, "-c", script], cwd=root, check=False).returncode == 0


def test_memory_stays_flat_over_many_scenes(tracer: Any) -> None:
    statm = Path("/proc/self/statm")
    used = []
    for number in range(24):
        scene = rack_wall(bays=2, levels=2, seed=number % 3)
        tracer.load(scene)
        tracer.render(CAMERA, scene.viewpoints[0].T_world_camera)
        used.append(int(statm.read_text().split()[1]) * 4096 / 2**20)
    assert max(used[18:]) - max(used[6:12]) < 30.0
