"""Hashes of scenes of the frozen recipe ``industrial-v1``, as they were stored when it was frozen.

Compared are the settled objects, the cameras, and of each observation the depth that was read, ids, masks and labels.
Colours are left out: a renderer may be mended. Hashes are those of one machine and its packages, as all bytes are.
"""

import hashlib
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.dataset.formats.kitti.reader import label_rows
from warehouse_sim.dataset.formats.observation_files import ObservationFiles
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.render import open_renderer
from warehouse_sim.schema import Observation, SceneSpec

NAME, SEED, SCENES = "industrial-v1", 0, (0, 1)
STORED = Path(__file__).with_name("frozen.json")
"""Hashes, and the machine that made them."""
_STEPS_PER_METRE = 10_000
"""Depth is compared as BOP stores it, 0.1 mm a step."""


def scene_hashes(index: int) -> dict[str, Any]:
    """Make one scene of the frozen recipe and return the hashes of its objects, cameras and observations."""
    recipe = load_recipe(NAME)
    sensors = replace(recipe.sensors, outputs=("depth", "masks", "amodal_masks", "poses"))  # colours take longest
    prepared = prepare_scene(recipe, SEED, index)
    with open_renderer("raster") as renderer:
        observations = observe_scene(prepared.scene, sensors, renderer, prepared.variants)
        return geometry_hashes(prepared.scene) | {"observations": list(map(observation_hashes, observations))}


def geometry_hashes(scene: SceneSpec) -> dict[str, str]:
    """Return the hashes of what stands in a settled scene, and of the cameras that look at it."""
    objects = sorted(scene.instances, key=lambda item: item.instance_id)
    stand = [(item.instance_id, item.model, scene.model_of(item).obj_id, item.T_world_object) for item in objects]
    return {
        "objects": _hash(stand),
        "cameras": _hash((view.kind, view.target, view.T_world_camera) for view in scene.viewpoints),
    }


def observation_hashes(observation: Observation) -> dict[str, str]:
    """Return the hashes of depth, instance ids, masks and labels of one observation."""
    targets = ObservationFiles(observation).targets
    shown = [item.annotation for item in targets]
    poses = [
        (item.instance_id, item.obj_id, item.pixels_all, item.pixels_visible, item.T_camera_object) for item in shown
    ]
    return {
        "depth": _hash([np.rint(observation.rgbd.depth * np.float32(_STEPS_PER_METRE)).astype(np.uint16)]),
        "ids": _hash([observation.buffers.instance_mask]),
        "masks": _hash(mask for item in targets for mask in (item.mask, item.mask_visible)),
        "labels": _hash([poses, label_rows(shown, observation.camera, NAME)]),
    }


def differences(stored: dict[str, Any], found: dict[str, Any], where: str) -> Iterator[str]:
    """Yield a line for each hash of ``stored`` that ``found`` lacks or has otherwise."""
    for key in ("objects", "cameras"):
        if stored[key] != found[key]:
            yield f"{where}: {key} differ from the frozen ones"
    if len(stored["observations"]) != len(found["observations"]):
        yield f"{where}: {len(found['observations'])} observations, frozen were {len(stored['observations'])}"
    for number, (old, new) in enumerate(zip(stored["observations"], found["observations"], strict=False)):
        yield from (f"{where}: observation {number}: {key} differ" for key in old if old[key] != new[key])


def _hash(items: Iterable[Any]) -> str:
    digest = hashlib.sha256()
    for part in _flat(items):
        # Poses to a nanometre: whether a zero has a sign is no difference.
        array = np.round(part, 9) + 0.0 if part.dtype.kind == "f" else part
        digest.update(f"{array.dtype.str}{array.shape}".encode() + array.tobytes())
    return digest.hexdigest()


def _flat(items: Iterable[Any]) -> Iterator[np.ndarray]:
    for item in items:
        if isinstance(item, list | tuple):
            yield from _flat(item)
        else:
            yield np.asarray(str(item)) if item is None else np.asarray(item)
