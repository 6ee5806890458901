"""Memory stays flat over many scenes and views in one process, and renderers can be opened and closed for ever."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render import Renderer, open_renderer
from warehouse_sim.render.conformance.scenes import rack_wall

pytestmark = pytest.mark.gl

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
    for _ in range(8):
        with open_renderer() as renderer:
            renderer.load(scene)
            renderer.render(SMALL, scene.viewpoints[0].T_world_camera)
        used.append(resident_mib())
    # A context with its shaders takes tens of MiB.
    assert used[-1] - used[3] < 30.0


@pytest.mark.slow
def test_fifty_scenes_with_twenty_observations_each_grow_by_less_than_five_percent() -> None:
    with open_renderer() as renderer:
        used = list(used_after_each(renderer, scenes=50, views=20, camera=KITTI))
    assert len(used) == 1000
    assert max(used[100:]) < 1.05 * max(used[:100])
