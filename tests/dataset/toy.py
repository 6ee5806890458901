"""A small warehouse drawn by exact ray casting against boxes in numpy: no renderer, every pixel known."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.split import SplitConfig, split_scenes
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.dataset.stored.recipe_contents import recipe_contents
from warehouse_sim.dataset.stored.scene_record import Outcome, SceneRecord
from warehouse_sim.dataset.validate import Check, requested_checks, run_check, validate
from warehouse_sim.geometry.boxes import OrientedBox, mask_box_xyxy
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import unit_box
from warehouse_sim.geometry.pose import invert, level_camera, make_transform, rotation_z
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import (
    LidarScan,
    Light,
    Material,
    MountedReading,
    ObjectAnnotation,
    ObjectInstance,
    ObjectModel,
    Observation,
    Part,
    Pocket,
    RenderBuffers,
    RgbdReading,
    SceneSpec,
    Viewpoint,
)

CAMERA = PinholeCamera(width=160, height=96, fx=110.0, fy=112.0, cx=81.3, cy=47.6)
T_CAMERA_LIDAR = make_transform(np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]]), np.array([0.0, -0.08, -0.27]))
RENDERER = "numpy ray caster"
SEED = 3


def box_model(name: str, class_name: str, obj_id: int, boxes: list[tuple], **more) -> ObjectModel:
    """Build a model of boxes given as (centre, size)."""
    parts = [Part(unit_box(), np.array(s), make_transform(None, np.array(c, dtype=float)), "wood") for c, s in boxes]
    corners = np.concatenate([part.placed().vertices for part in parts])
    size = corners.max(axis=0) - corners.min(axis=0)
    return ObjectModel(name, class_name, obj_id, size, tuple(parts), (OrientedBox(np.eye(4), size),), **more)


# Two decks on two skids: 1200 x 800 x 144 mm, open from the -y and +y sides.
PALLET = box_model(
    "toy-pallet",
    "pallet",
    1,
    [((0, 0, 0.052), (1.2, 0.8, 0.04)), ((-0.5, 0, -0.02), (0.2, 0.8, 0.104)), ((0.5, 0, -0.02), (0.2, 0.8, 0.104))],
    symmetry=SymmetryGroup.turns("z", 2),
    pockets=tuple(
        Pocket(face, make_transform(rotation_z(yaw), np.array([0.0, y, -0.02])), np.array([0.8, 0.8, 0.104]))
        for face, yaw, y in (("-y", np.pi / 2, -0.4), ("+y", -np.pi / 2, 0.4))
    ),
)
CARTON = box_model("toy-carton", "carton", 7, [((0, 0, 0), (0.4, 0.3, 0.25))], symmetry=SymmetryGroup.cuboid())
FLOOR = box_model("toy-floor", "floor", 90, [((0, 0, 0), (40.0, 40.0, 0.2))])
MODELS = {model.name: model for model in (PALLET, CARTON, FLOOR)}


@cache
def make_scene(scene_index: int) -> SceneSpec:
    """Place three pallets, one occluded by a carton and one cut by the image border; the last camera sees none."""
    rng = np.random.default_rng([SEED, scene_index])
    instances = [ObjectInstance(1, FLOOR.name, make_transform(None, np.array([0.0, 0.0, -0.1])))]
    for i, (x, y) in enumerate([(3.2, 0.3), (4.6, -1.1), (4.9, 3.5)]):
        where = np.array([*(np.array([x, y]) + rng.uniform(-0.1, 0.1, 2)), 0.072])
        turn = rotation_z(rng.uniform(-0.5, 0.5))
        instances.append(ObjectInstance(10 + i, PALLET.name, make_transform(turn, where), True, 1 + i))
    instances.append(ObjectInstance(20, CARTON.name, make_transform(None, np.array([3.0, 0.5, 0.269])), True, 1))
    cameras = [level_camera(np.array([0.0, 0.0, 0.9]), yaw) for yaw in (0.0, np.pi)]
    return SceneSpec(
        scene_index=scene_index,
        seed=SEED,
        models=MODELS,
        materials={"wood": Material("wood", (0.5, 0.4, 0.3))},
        instances=tuple(instances),
        lights=(Light("spot", np.array([1.0, 0, 5]), np.array([0.0, 0, -1]), 800.0),),
        viewpoints=tuple(Viewpoint(T) for T in cameras),
        settled=True,
    )


@cache
def observe(scene: SceneSpec) -> tuple[Observation, ...]:
    """Return exact observations of every viewpoint."""
    return tuple(observation_of(scene, i, viewpoint.T_world_camera) for i, viewpoint in enumerate(scene.viewpoints))


def observation_of(scene: SceneSpec, index: int, T_world_camera: np.ndarray) -> Observation:
    """Ray-cast one observation: image, amodal masks over three images each way, and a LiDAR sweep."""
    T_camera_world = invert(T_world_camera)
    depth, ids = cast(scene, T_world_camera, CAMERA.rays())
    rgb = ((ids[..., None] * [37, 91, 53] + np.arange(CAMERA.width)[None, :, None]) % 256).astype(np.uint8)
    annotations = []
    for instance in scene.target_instances():
        annotation = annotate(scene, instance, T_camera_world @ instance.T_world_object, depth, ids)
        if annotation is not None:
            annotations.append(annotation)
    return Observation(
        scene_index=scene.scene_index,
        observation_index=index,
        camera=CAMERA,
        T_world_camera=T_world_camera,
        readings={
            "camera": MountedReading(np.eye(4), RgbdReading(rgb, depth)),
            "lidar": MountedReading(T_CAMERA_LIDAR, sweep(scene, T_world_camera @ T_CAMERA_LIDAR)),
        },
        buffers=RenderBuffers(rgb, depth, ids),
        annotations=tuple(annotations),
    )


def annotate(scene, instance, T_camera_object, depth, ids) -> ObjectAnnotation | None:
    """Label one target from a ray-cast of it alone."""
    w, h = CAMERA.width, CAMERA.height
    large = PinholeCamera(3 * w, 3 * h, CAMERA.fx, CAMERA.fy, CAMERA.cx + w, CAMERA.cy + h)
    alone = cast_boxes(scene.model_of(instance), T_camera_object, large.rays()) < np.inf
    box = mask_box_xyxy(alone)
    inside = alone[h : 2 * h, w : 2 * w]
    if box is None or not inside.any():
        return None
    visible = ids == instance.instance_id
    left, top, right, bottom = box
    return ObjectAnnotation(
        instance_id=instance.instance_id,
        class_name=scene.model_of(instance).class_name,
        obj_id=scene.model_of(instance).obj_id,
        T_camera_object=T_camera_object,
        size=scene.model_of(instance).size,
        box_amodal_xyxy=(float(left - w), float(top - h), float(right - w), float(bottom - h)),
        box_visible_xyxy=mask_box_xyxy(visible),
        amodal_mask_offset=(left - w, top - h),
        amodal_mask=alone[top : bottom + 1, left : right + 1],
        pixels_all=int(alone.sum()),
        pixels_in_image=int(inside.sum()),
        pixels_visible=int(visible.sum()),
        pixels_valid=int((visible & (depth > 0)).sum()),
    )


def cast(scene: SceneSpec, T_world_camera: np.ndarray, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the nearest ray parameter (z-depth for rays with z = 1) as float32 and the instance ids."""
    nearest, ids = np.full(rays.shape[:-1], np.inf), np.zeros(rays.shape[:-1], dtype=np.int32)
    for instance in scene.instances:
        t = cast_boxes(scene.model_of(instance), invert(T_world_camera) @ instance.T_world_object, rays)
        ids[t < nearest] = instance.instance_id
        nearest = np.minimum(nearest, t)
    # What is too far for the sensor gives no reading but keeps its id.
    return np.where(nearest < 30.0, nearest, 0.0).astype(np.float32), ids


def cast_boxes(model: ObjectModel, T_camera_object: np.ndarray, rays: np.ndarray) -> np.ndarray:
    """Return the ray parameter of the first hit with any part, by the slab test."""
    nearest = np.full(rays.shape[:-1], np.inf)
    for part in model.parts:
        T_part_camera = invert(T_camera_object @ part.T_object_part)
        origin, directions = T_part_camera[:3, 3], rays @ T_part_camera[:3, :3].T
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = np.stack([(sign * part.scale / 2 - origin) / directions for sign in (-1, 1)])
        enter, leave = ends.min(axis=0).max(axis=-1), ends.max(axis=0).min(axis=-1)
        nearest = np.where((enter <= leave) & (enter > 0), np.minimum(nearest, enter), nearest)
    return nearest


def sweep(scene: SceneSpec, T_world_lidar: np.ndarray) -> LidarScan:
    """Return one turn of a LiDAR of 24 beams."""
    elevation, azimuth = np.meshgrid(np.linspace(0.03, -0.4, 24), np.linspace(-np.pi, np.pi, 360), indexing="ij")
    flat = np.cos(elevation)
    rays = np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)], axis=-1)
    distance, ids = cast(scene, T_world_lidar, rays)
    hit = distance > 0
    rings = np.broadcast_to(np.arange(24, dtype=np.int32)[:, None], ids.shape)
    points = (rays[hit] * distance[hit][:, None]).astype(np.float32)
    times = np.broadcast_to(np.linspace(0.0, 0.1, 360, dtype=np.float32), ids.shape)
    return LidarScan(points, np.full(len(points), 0.25, dtype=np.float32), ids[hit], rings[hit], times[hit])


def make_manifest(scenes: int = 3, formats: tuple[str, ...] = ("kitti", "bop")) -> Manifest:
    """Return the manifest of a toy dataset of two observations a scene."""
    splits = split_scenes(scenes, SplitConfig())
    recipe = {"description": "toy"}
    return Manifest(
        SEED,
        scenes,
        2,
        dict(splits),
        formats,
        ("pallet",),
        recipe=recipe,
        packages={"numpy": "any"},
        contents=recipe_contents(recipe),
    )


def with_recipe(manifest: Manifest, recipe: dict) -> Manifest:
    """Return the manifest of a dataset that was made from another recipe."""
    return replace(manifest, recipe=recipe, contents=recipe_contents(recipe))


def make_dataset(
    root: Path,
    manifest: Manifest | None = None,
    order: list[int] | None = None,
    change: Callable[[Observation], Observation] = lambda observation: observation,
    scene_of: Callable[[int], SceneSpec] = make_scene,
) -> Path:
    """Write a whole toy dataset, its scenes in the given order, of observations as ``change`` returns them."""
    store = DatasetStore(root, manifest or make_manifest())
    store.begin([PALLET], CAMERA)
    for index in order or range(store.manifest.scenes):
        scene = scene_of(index)
        store.write_scene(scene, map(change, observe(scene)), Outcome({"problems": [], "speed": 0.0}, RENDERER))
    store.finish()
    return root


def failures(root: Path) -> dict[str, str]:
    """Return what ``validate`` finds, by the name of the check."""
    return {check.name: check.detail for check in validate(root) if not check.ok}


def outcome(root: Path, name: str) -> Check:
    """Return what one check of ``validate`` says; the others are not run."""
    (found,) = [run_check(check, seen) for check, seen in requested_checks(root) if check.name == name]
    return found


def write_scene(store: DatasetStore, index: int) -> SceneRecord:
    """Draw and store one scene."""
    scene = make_scene(index)
    return store.write_scene(scene, observe(scene), Outcome({"problems": [], "speed": 0.0}, RENDERER))


def write_scenes(root: Path, manifest: Manifest, indices: list[int]) -> None:
    """Store some scenes, as a worker process does."""
    store = DatasetStore(root, manifest)
    for index in indices:
        write_scene(store, index)
