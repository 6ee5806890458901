"""What two scenes have in common is uploaded and drawn once; the images are those of a renderer that starts again."""

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.render.test_backend import digest
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render import Renderer, open_renderer
from warehouse_sim.render.conformance.scenes import at, rack_wall, spot
from warehouse_sim.render.light_selection import light_geometry
from warehouse_sim.render.raster import backend, loaded_scene
from warehouse_sim.render.raster.light.shadows import ShadowAtlas
from warehouse_sim.render.raster.meshes.mesh_batch import MeshBatch
from warehouse_sim.schema import SceneSpec

pytestmark = pytest.mark.gl


@pytest.fixture
def counts(monkeypatch: pytest.MonkeyPatch) -> dict[str, int]:
    """Count how often tables are built, meshes uploaded and shadow maps drawn."""
    found = {"tables": 0, "meshes": 0, "shadows": 0, "checks": 0}

    def counted(owner: object, name: str, key: str) -> None:
        original = getattr(owner, name)

        def call(*arguments: object, **keywords: object) -> object:
            found[key] += 1
            return original(*arguments, **keywords)

        monkeypatch.setattr(owner, name, call)

    counted(loaded_scene, "build_part_table", "tables")
    counted(MeshBatch, "__init__", "meshes")
    counted(ShadowAtlas, "draw", "shadows")
    counted(backend, "require_renderable", "checks")
    return found


def with_other_light(scene: SceneSpec) -> SceneSpec:
    lights = (spot((2.0, 1.0, 7.0), 6000.0), spot((0.5, -2.0, 6.0), 2500.0))
    return replace(scene, lights=lights, ambient=12.0, exposure=0.02)


def brighter(scene: SceneSpec) -> SceneSpec:
    lights = tuple(replace(light, intensity=2.0 * light.intensity, color=(1.0, 0.9, 0.8)) for light in scene.lights)
    return replace(scene, lights=lights)


def moved(scene: SceneSpec) -> SceneSpec:
    last = scene.instances[-1]
    T = at(0.0, 0.0, 0.05) @ last.T_world_object
    return replace(scene, instances=(*scene.instances[:-1], replace(last, T_world_object=T)))


def test_each_scene_does_only_what_is_new_and_looks_as_if_it_were_the_first(counts: dict[str, int]) -> None:
    wall = rack_wall(bays=1)
    wall = replace(wall, viewpoints=wall.viewpoints[:2])
    half = replace(wall, viewpoints=wall.viewpoints[:1])
    other = rack_wall(bays=1, seed=2)
    other = replace(other, viewpoints=other.viewpoints[:2])
    steps = [
        (wall, {"tables": 1, "meshes": 1, "shadows": 1, "checks": 1}),
        (wall, {"tables": 0, "meshes": 0, "shadows": 0}),
        (half, {"tables": 0, "meshes": 0}),
        (brighter(half), {"tables": 0, "meshes": 0, "shadows": 0, "checks": 0}),
        (with_other_light(wall), {"tables": 0, "meshes": 0, "shadows": 1}),
        (moved(wall), {"tables": 1, "meshes": 0, "shadows": 1, "checks": 1}),
        (other, {"tables": 1, "meshes": 0, "shadows": 1}),
        (wall, {"tables": 1, "meshes": 0, "shadows": 1}),
    ]
    digests = []
    with open_renderer() as used:
        for scene, expected in steps:
            before = dict(counts)
            digests.append(digest(used, scene))
            assert {key: counts[key] - before[key] for key in expected} == expected
    of_wall = {seen for (scene, _), seen in zip(steps, digests, strict=True) if scene is wall}
    assert len(of_wall) == 1
    # Not the wall, which was the first, nor its half, which shows no more than it.
    for (scene, _), seen in list(zip(steps, digests, strict=True))[3:-1]:
        with open_renderer() as fresh:
            assert digest(fresh, scene) == seen
    assert len(set(digests)) == 6


def test_lights_stand_as_before_by_what_shades() -> None:
    light = spot((1.0, 2.0, 3.0))
    assert light_geometry(light) == light_geometry(replace(spot((1.0, 2.0, 3.0)), intensity=7.0, color=(1.0, 0.5, 0.2)))
    for other in (
        replace(light, position=np.array([1.0, 2.0, 3.1])),
        replace(light, radius=0.3),
        replace(light, kind="point"),
    ):
        assert light_geometry(light) != light_geometry(other)


# Memory stays flat over many scenes and views in one process, and renderers can be opened and closed for ever.


SMALL = PinholeCamera.from_focal(320, 100, 190.0)
KITTI = PinholeCamera.from_focal(1224, 370, 721.5377)


def resident_mib() -> float:
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20


def used_after_each(renderer: Renderer, scenes: int, views: int, camera: PinholeCamera) -> Iterator[float]:
    """Load scenes that all differ, draw each ``views`` times; yield the memory in use (MiB) after each view."""
    for number in range(scenes):
        scene = rack_wall(bays=1 + number % 3, levels=1 + number % 2, seed=number)
        renderer.load(scene)
        for view in range(views):
            T = scene.viewpoints[view % len(scene.viewpoints)].T_world_camera
            renderer.render(camera, T, normals=view % 2 == 0)
            renderer.amodal_masks(camera, T, scene.target_instances())
            yield resident_mib()


def test_renderers_opened_and_closed_leave_nothing_behind() -> None:
    scene, used = rack_wall(bays=1, levels=1), []
    for _ in range(6):
        with open_renderer() as renderer:
            renderer.load(scene)
            renderer.render(SMALL, scene.viewpoints[0].T_world_camera)
        used.append(resident_mib())
    # A context with its shaders takes tens of MiB.
    assert used[-1] - used[2] < 30.0


@pytest.mark.slow
def test_fifty_scenes_with_twenty_observations_each_grow_by_less_than_five_percent() -> None:
    with open_renderer() as renderer:
        used = list(used_after_each(renderer, scenes=50, views=20, camera=KITTI))
    assert len(used) == 1000
    assert max(used[100:]) < 1.05 * max(used[:100])
