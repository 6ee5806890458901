"""Poses of pallets in sampled scenes with errors that are known, which both judges of a docking are shown."""

import zlib
from collections.abc import Iterator

import numpy as np

from tests.benchmark.docking.stations import estimate
from warehouse_sim.annotate.dockable import accessibility
from warehouse_sim.annotate.trucks import TRUCKS
from warehouse_sim.benchmark.docking.questions import Question, why_not
from warehouse_sim.benchmark.docking.station import Station, station_of
from warehouse_sim.evaluation.docking.fork import (
    HEEL_GAP,
    MIN_INSERTION,
    REACH,
    TINE_THICKNESS,
    TINE_WIDTH,
    DockingFace,
    approached_face,
    docking_faces,
)
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import sample_settled_scene
from warehouse_sim.geometry.pose import Transform, invert
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import SceneSpec

AXES = ("lateral", "vertical", "depth", "yaw", "pitch")
KINDS = ("oracle", "too deep", *AXES, "all")
"""The ground truth itself, 0.2 m too deep, one error alone, and all five at once."""
_DEEP = 0.2
_ALONE, _TOGETHER = 2.0, 0.7
"""Errors are uniform up to this fraction of their limit, when alone and when all five come together."""
_SIDES_A_SCENE = 5
"""Sides of pallets on which errors are planted in one scene: poses of one scene are alike, so more scenes say more."""
_FARTHEST, _LEAST_AHEAD = 10.0, 0.5
"""Pallets between these distances before a viewpoint (m) are evaluated, seen or hidden."""


def planted(kind: str, station: Station, face: DockingFace, rng: np.random.Generator) -> Transform:
    """Return an estimate in the true object frame with an error of this kind, sampled from ``rng``."""
    errors = dict.fromkeys(AXES, 0.0)
    if kind == "too deep":
        errors["depth"] = _DEEP
    for name in AXES if kind == "all" else (kind,) if kind in AXES else ():
        below, above = limits(face)[name]
        fraction = float(rng.uniform(-1.0, 1.0)) * (_TOGETHER if kind == "all" else _ALONE)
        errors[name] = fraction * (above if fraction > 0.0 else below)
    return estimate(station, face.name, **errors)


def limits(face: DockingFace) -> dict[str, tuple[float, float]]:
    """Return how far each error alone may go, below and above 0 (m, rad), both positive, in the middle of a pocket."""
    clear = np.min([pocket.size for pocket in face.pockets], axis=0)
    beside, above = (clear[1:] - [TINE_WIDTH, TINE_THICKNESS]) / 2.0
    inside = min(float(clear[0]), REACH)
    short = max(REACH - MIN_INSERTION * face.depth, 0.0)
    return {
        "lateral": (beside, beside),
        "vertical": (above, above),
        "depth": (short, HEEL_GAP),
        "yaw": (beside / inside, beside / inside),
        "pitch": (above / inside, above / inside),
    }


def questions(name: str, most: int, seed: int = 0) -> Iterator[tuple[Question, Station]]:
    """Yield ``most`` questions about scenes of a recipe, every kind of each side that a truck reaches."""
    found, recipe = 0, load_recipe(name)
    for index in range(1_000_000):
        sampled = sample_settled_scene(recipe, seed, index)
        reach = accessibility(sampled.scene, TRUCKS[sampled.settings.layout.truck])
        solids, sides = Solids.of(sampled.scene.instances, sampled.scene.models), 0
        for image, instance, side in _before_viewpoints(sampled.scene):
            station = station_of(sampled.scene, instance, solids)
            face = station.face(side)
            if sides == _SIDES_A_SCENE or why_not(station, face, reach[instance].faces[side]):
                continue
            sides += 1
            for kind in KINDS:
                # Each question has a stream of its own, so that it is the same whatever was evaluated before.
                rng = np.random.default_rng([seed, index, instance, zlib.crc32(f"{side} {kind}".encode())])
                yield Question(name, index, image, instance, side, kind, planted(kind, station, face, rng)), station
                found += 1
                if found == most:
                    return


def _before_viewpoints(scene: SceneSpec) -> Iterator[tuple[int, int, str]]:
    seen = set()
    for number, view in enumerate(scene.viewpoints):
        for item in scene.target_instances():
            model = scene.model_of(item)
            T = invert(view.T_world_camera) @ item.T_world_object
            if not model.pockets or T[2, 3] < _LEAST_AHEAD or np.linalg.norm(T[:3, 3]) > _FARTHEST:
                continue
            faces = docking_faces(model.size, model.pockets)
            face = faces[int(approached_face(T[None], faces)[0])].name
            if (item.instance_id, face) not in seen:
                seen.add((item.instance_id, face))
                yield number, item.instance_id, face
