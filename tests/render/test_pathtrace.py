from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from scipy.stats import qmc

from tests.render.opened import open_pathtracer
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render import Renderer
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene, rack_wall, spot
from warehouse_sim.schema import Material, SceneSpec

CAMERA = PinholeCamera.from_focal(320, 200, 190.0)


@pytest.fixture(scope="module")
def tracer() -> Iterator[Any]:
    with open_pathtracer(samples=2) as opened:
        yield opened


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
        with open_pathtracer(samples=128) as sharp:
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
    for samples, seed in ((4, 1), (64, 2), (512, 3)):
        with open_pathtracer(samples=samples, seed=seed) as renderer:
            renderer.load(wall)
            found.append(renderer.luminance(camera, T))
    coarse, fine = (np.sqrt(((item - found[2]) ** 2).mean()) for item in found[:2])
    assert fine < 0.4 * coarse  # a quarter in theory


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


def test_memory_stays_flat_over_many_scenes(tracer: Any) -> None:
    statm = Path("/proc/self/statm")
    used = []
    for number in range(24):
        scene = rack_wall(bays=1, levels=1, seed=number % 3)
        tracer.load(scene)
        tracer.render(CAMERA, scene.viewpoints[0].T_world_camera)
        used.append(int(statm.read_text().split()[1]) * 4096 / 2**20)
    assert max(used[18:]) - max(used[6:12]) < 30.0


# The path tracer's random numbers: those of scipy before scrambling, even in every pixel after it.


@pytest.fixture(scope="module", autouse=True)
def variant() -> None:
    open_pathtracer().close()


def draws(seed: int, pixels: int, count: int, first: int = 0) -> list[np.ndarray]:
    """Return one draw of two numbers, one of one and another of two, each (pixels, count, dimensions)."""
    import drjit as dr
    import mitsuba as mi

    from warehouse_sim.render.pathtrace.sobol import sobol_sampler

    path = dr.arange(mi.UInt32, pixels * count)
    sampler = sobol_sampler(seed, path // count, path % count + first)
    sampled = [sampler.next_2d().numpy().T, sampler.next_1d().numpy()[:, None], sampler.next_2d().numpy().T]
    return [item.reshape(pixels, count, -1) for item in sampled]


def test_unscrambled_they_are_sobols_points() -> None:
    import drjit as dr
    import mitsuba as mi

    from warehouse_sim.render.pathtrace.sobol import second_dimension

    first = dr.brev(dr.arange(mi.UInt32, 256))
    ours = np.stack([first.numpy(), second_dimension(first).numpy()], axis=-1) / 2.0**32
    theirs = qmc.Sobol(2, scramble=False).random(256)  # the same points in the order of a Gray code
    assert set(map(tuple, ours)) == set(map(tuple, theirs))


def test_every_pixel_has_one_point_in_each_cell_of_every_shape() -> None:
    for seed in (0, 2**32 - 1):
        first, single, second = draws(seed, 200, 64)
        for points in (first, second):
            for across in (1, 2, 4, 8, 16, 32, 64):
                cell = np.floor(points * [across, 64 // across]).astype(int)
                number = np.sort(cell[..., 0] * (64 // across) + cell[..., 1], axis=1)
                assert (number == np.arange(64)).all()
        assert (np.sort(np.floor(64 * single[..., 0]), axis=1) == np.arange(64)).all()
        assert min(item.min() for item in (first, single, second)) >= 0.0
        assert max(item.max() for item in (first, single, second)) < 1.0


def test_draws_pixels_and_seeds_know_nothing_of_each_other() -> None:
    first, single, second = draws(1, 4000, 16)
    other = draws(2, 4000, 16)[0]
    columns = [*first.reshape(-1, 2).T, single.ravel(), *second.reshape(-1, 2).T, *other.reshape(-1, 2).T]
    columns.append(np.roll(first, 1, axis=0)[..., 0].ravel())
    matrix = np.corrcoef(np.stack(columns)) - np.eye(len(columns))
    assert np.abs(matrix).max() < 0.02


def test_passes_go_on_where_the_one_before_ended() -> None:
    whole = draws(7, 50, 48)
    parts = [draws(7, 50, count, start) for start, count in ((0, 20), (20, 28))]
    for number, item in enumerate(whole):
        assert np.array_equal(item, np.concatenate([part[number] for part in parts], axis=1))
