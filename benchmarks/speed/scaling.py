"""What a frame costs as the scene grows: the same hall cut to its nearest 10, 100, 1,000 and 10,000 instances.

Two views: across the aisle, where culling leaves little, and along it, where far goods are drawn small. The hall is one
dense rack aisle, settled and lit, with copies of it at its end, so that the aisle goes on for a hundred metres.
"""

import statistics
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Float

from benchmarks.speed.cost import Cost
from benchmarks.speed.render_process import RenderProcess, render_in_turns
from benchmarks.speed.scene_statistics import DENSE
from benchmarks.speed.subject import Settings, scene_facts
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.geometry.pose import Transform, level_camera, make_transform
from warehouse_sim.schema import SceneSpec

SIZES, QUICK_SIZES = (10, 100, 1_000, 10_000), (10, 100)
PEER = "mujoco"
HEADINGS = {"across": np.pi / 2, "along": 0.0}
"""Yaw of each view (rad)."""


def scaling(settings: Settings) -> dict[str, Any]:
    """Return the row; its times are those of the largest scene, and its table has all sizes."""
    hall = _hall(settings)
    eye = _eye(hall)
    views = [level_camera(eye, yaw) for yaw in HEADINGS.values()]
    sizes = QUICK_SIZES if settings.quick else SIZES
    table = [_measure(nearest(hall, size, eye), views, settings) for size in sizes]
    first, last = table[0], table[-1]
    return {
        "what": f"a frame of {last['instances']} instances, mean of two views",
        "ours_cpu_s": last["ours_cpu_s"],
        "peer_cpu_s": last["peer_cpu_s"],
        "target": "sub-linear",
        "growth": {
            "instances": last["instances"] / first["instances"],
            "ours": last["ours_cpu_s"] / first["ours_cpu_s"],
            "peer": last["peer_cpu_s"] / first["peer_cpu_s"],
        },
        "table": table,
        "peer": PEER,
        "how": "as in the rows rgbd_ids; load is what a new scene costs once, with shadow maps or a compiled model",
    }


def nearest(hall: SceneSpec, size: int, eye: Float[np.ndarray, " 3"]) -> SceneSpec:
    """Return ``hall`` with the ``size`` instances whose centres are nearest to ``eye`` (m), the floor among them."""
    floors = [item for item in hall.instances if hall.model_of(item).class_name == "floor"]
    others = [item for item in hall.instances if hall.model_of(item).class_name != "floor"]
    others.sort(key=lambda item: float(np.linalg.norm(item.T_world_object[:3, 3] - eye)))
    return replace(hall, instances=(*floors, *others)[:size])


def _hall(settings: Settings) -> SceneSpec:
    recipe = Recipe("A dense rack aisle.", DENSE, name="dense")
    hall = prepare_scene(recipe, settings.seed, 0).scene
    return hall if settings.quick else continued(hall, copies=3)


def continued(hall: SceneSpec, copies: int) -> SceneSpec:
    """Return ``hall`` with everything but its lights and walls standing ``copies`` times in a row along x."""
    racks = [item.T_world_object[0, 3] for item in hall.instances if hall.model_of(item).class_name == "rack"]
    length = float(np.ptp(racks)) + 1.0
    count = max(item.instance_id for item in hall.instances)
    instances = [
        replace(
            item,
            instance_id=item.instance_id + number * count,
            T_world_object=make_transform(np.eye(3), np.array([number * length, 0.0, 0.0])) @ item.T_world_object,
        )
        for number in range(copies)
        for item in hall.instances
        if hall.model_of(item).class_name not in ("wall", "door")  # they would close the aisle
    ]
    return replace(hall, instances=tuple(instances))


def _eye(hall: SceneSpec) -> Float[np.ndarray, " 3"]:
    """Return a place in the middle of the aisle, eight metres behind where the racks begin."""
    racks = [item for item in hall.instances if hall.model_of(item).class_name == "rack"]
    places = np.array([item.T_world_object[:3, 3] for item in racks])
    low, high = places.min(axis=0), places.max(axis=0)
    return np.array([low[0] + 8.0, (low[1] + high[1]) / 2, 1.6])


def _measure(scene: SceneSpec, views: list[Transform], settings: Settings) -> dict[str, Any]:
    camera = load_recipe(settings.recipe).sensors.make_camera()
    with RenderProcess("raster", scene, camera) as ours, RenderProcess(PEER, scene, camera) as theirs:
        sampled = render_in_turns([ours, theirs], views, repeats=1 if settings.quick else 3)
        loads = {"ours_load_cpu_s": ours.load_cost.cpu_s, "peer_load_cpu_s": theirs.load_cost.cpu_s}
    by_view = [_by_view(costs) for costs in sampled]
    return {
        "instances": len(scene.instances),
        "triangles": scene_facts(scene)["triangles"],
        "ours_cpu_s": statistics.mean(by_view[0].values()),
        "peer_cpu_s": statistics.mean(by_view[1].values()),
        **{f"ours_{name}_cpu_s": cpu_s for name, cpu_s in by_view[0].items()},
        **{f"peer_{name}_cpu_s": cpu_s for name, cpu_s in by_view[1].items()},
        **loads,
    }


def _by_view(costs: tuple[Cost, ...]) -> dict[str, float]:
    """Return the median CPU time of each view; the views follow one another in ``costs``."""
    count = len(HEADINGS)
    return {name: statistics.median(cost.cpu_s for cost in costs[at::count]) for at, name in enumerate(HEADINGS)}
