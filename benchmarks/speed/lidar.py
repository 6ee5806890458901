"""Rays a second, end to end: sweeps of 64 beams with edges, noise and ids, against the bare rays of Open3D."""

from typing import Any

import numpy as np

from benchmarks.speed.cost import Cost, measure, median
from benchmarks.speed.lidar_workers import side_by_side, sweep_to_bytes
from benchmarks.speed.subject import Settings, Subject, render_subject
from warehouse_sim.geometry.mesh import TriangleMesh, merge
from warehouse_sim.geometry.pose import Transform, transform_points
from warehouse_sim.optional import require
from warehouse_sim.processes import keep_freed_memory
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import SceneSpec
from warehouse_sim.sensors.lidar import LIDAR_PRESETS, LidarConfig
from warehouse_sim.sensors.lidar.footprint import see_sweep
from warehouse_sim.sensors.lidar.read import world_rays
from warehouse_sim.sensors.lidar.sweep import make_sweep

SWEEPS, QUICK_SWEEPS = 24, 2
"""Of each of the two processes, in each round."""


def lidar(settings: Settings) -> dict[str, Any]:
    """Return the row; the peer casts the rays of the beams' axes, and neither probes edges nor adds noise."""
    keep_freed_memory()  # as workers do
    subject = render_subject(settings)
    config = LidarConfig()
    built, raycaster = measure(RayCaster, subject.scene)
    their_scene, their_build = _open3d_scene(subject)
    places = [view @ subject.recipe.sensors.mounted()["lidar"].T_camera_sensor() for view in subject.views]
    ours: list[Cost] = []
    theirs: list[Cost] = []
    for T_world_lidar in (places[0], *places):
        ours.append(
            measure(sweep_to_bytes, subject.scene, raycaster, config, T_world_lidar, np.random.default_rng(0))[0]
        )
        origins, directions = world_rays(make_sweep(config), T_world_lidar)
        theirs.append(measure(their_scene.cast_rays, np.concatenate([origins, directions], axis=1))[0])
    our_median, peer_median = median(ours[1:]), median(theirs[1:])
    beams = len(make_sweep(config).time)
    rays = float(np.mean([_rays_cast(raycaster, config, T_world_lidar) for T_world_lidar in places]))
    sweeps = QUICK_SWEEPS if settings.quick else SWEEPS
    return {
        "what": "a 64-beam sweep: directions, rays, edges, dropout, noise, ids, arrays as they are written",
        "ours_cpu_s": our_median.cpu_s,
        "peer_cpu_s": peer_median.cpu_s,
        "beams": beams,
        "rays": rays,
        "ours_beams_per_cpu_s": beams / our_median.cpu_s,
        "ours_rays_per_cpu_s": rays / our_median.cpu_s,
        "peer_rays_per_cpu_s": beams / peer_median.cpu_s,
        "target": "two processes on two cores: >= 4 M rays a second",
        "two_processes": side_by_side(subject.scene, config, places, rays, beams, sweeps),
        "presets_cpu_s": _presets(subject.scene, raycaster, places),
        "ours_wall_s": our_median.wall_s,
        "peer_wall_s": peer_median.wall_s,
        "ours_load_cpu_s": built.cpu_s,
        "peer_load_cpu_s": their_build.cpu_s,
        "peer": f"Open3D {require('open3d', 'open3d', 'for the LiDAR row').__version__}",
        "how": "open3d.t.geometry.RaycastingScene.cast_rays of the beams' axes in one call: distances, ids, normals",
    }


def _presets(scene: SceneSpec, raycaster: RayCaster, places: list[Transform]) -> dict[str, float]:
    """Return the CPU time of a sweep of each preset (s), median over the places after a warm-up."""
    found = {}
    for name, config in LIDAR_PRESETS.items():
        costs = [
            measure(sweep_to_bytes, scene, raycaster, config, place, np.random.default_rng(0))[0]
            for place in (places[0], *places)
        ]
        found[name] = median(costs[1:]).cpu_s
    return found


def _rays_cast(raycaster: RayCaster, config: LidarConfig, T_world_lidar: Transform) -> int:
    """Return how many rays a sweep takes: one a beam, and more at edges."""
    sweep = make_sweep(config)
    return see_sweep(raycaster, config, sweep, *world_rays(sweep, T_world_lidar)).rays


def _open3d_scene(subject: Subject) -> tuple[Any, Cost]:
    open3d = require("open3d", "open3d", "for the LiDAR row")
    mesh = _solid_mesh(subject)

    def build() -> Any:
        scene = open3d.t.geometry.RaycastingScene()
        scene.add_triangles(mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32))
        return scene

    cost, scene = measure(build)
    return scene, cost


def _solid_mesh(subject: Subject) -> TriangleMesh:
    """Return what stops rays: all parts but film, in the world."""
    scene = subject.scene
    placed = [
        (instance.T_world_object, part.placed())
        for instance in scene.instances
        for part in scene.model_of(instance).parts
        if scene.materials[part.material].opacity >= 1.0
    ]
    return merge([TriangleMesh(transform_points(T, mesh.vertices), mesh.faces) for T, mesh in placed])
