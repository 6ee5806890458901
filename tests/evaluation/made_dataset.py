"""A small dataset in real files: pallets drawn as flat amodal masks, stored by the dataset writers."""

from pathlib import Path

import cv2
import numpy as np

from tests.evaluation.pallet import nudge, seen_from
from warehouse_sim.catalog.loads.cartons import SKUS, carton
from warehouse_sim.catalog.pallets import pallet
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results import pose_csv
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.dataset.stored.recipe_contents import recipe_contents
from warehouse_sim.dataset.stored.scene_record import Outcome
from warehouse_sim.geometry.boxes import box_corners, mask_box_xyxy
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.schema import (
    MountedReading,
    ObjectAnnotation,
    ObjectInstance,
    Observation,
    PoseEstimate,
    RenderBuffers,
    RgbdReading,
    SceneSpec,
)

CAMERA = PinholeCamera.from_focal(320, 120, 180.0)
MODELS = (pallet("epal1"), carton(sorted(SKUS)[0]))
PLACES = ((2.5, -0.7, 0.1), (4.5, 0.6, -1.2), (7.0, -0.9, 0.4), (9.0, 1.0, 3.0), (3.2, 0.9, 1.6))
"""Distance ahead, offset to the left (m) and heading (rad) of what can stand in an image."""


def make_dataset(root: Path, scenes: int = 4, seed: int = 0) -> Path:
    """Write ``scenes`` scenes with two images of three to four objects each; the last half is the test split."""
    half = scenes // 2
    splits = {"train": tuple(range(half)), "val": (), "test": tuple(range(half, scenes))}
    recipe = {"name": "made", "description": "pallets as flat amodal masks"}
    targets, contents = ("pallet", "carton"), recipe_contents(recipe)
    manifest = Manifest(
        seed, scenes, 2, splits, ("bop",), targets, recipe, {"numpy": np.__version__}, contents=contents
    )
    store = DatasetStore(root, manifest)
    store.begin(MODELS, CAMERA)
    for index in range(scenes):
        rng = np.random.default_rng([seed, index])
        spec = SceneSpec(index, seed, {model.name: model for model in MODELS}, {}, _instances(), (), (), settled=True)
        store.write_scene(spec, [_observe(index, number, rng) for number in range(2)], Outcome({}, "amodal masks"))
    store.finish()
    return root


def estimates_of(data: Path, split: str = "test", score: float = 1.0, time: float = 0.05) -> list[PoseEstimate]:
    """The ground truth of a split as estimates, in order of image and label."""
    return [
        PoseEstimate(image.scene_id, image.image_id, target.obj_id, score, target.T_camera_object, time)
        for image in DatasetReader(data).images(split)
        for target in image.targets
    ]


def write_estimates(estimates: list[PoseEstimate], path: Path) -> Path:
    pose_csv.write(path, estimates)
    return path


def _instances() -> tuple[ObjectInstance, ...]:
    names = [MODELS[0].name] * 4 + [MODELS[1].name]
    return tuple(ObjectInstance(number + 1, name, np.eye(4)) for number, name in enumerate(names))


def _observe(scene: int, number: int, rng: np.random.Generator) -> Observation:
    ids = np.zeros((CAMERA.height, CAMERA.width), np.int32)
    depth = np.zeros(ids.shape, np.float32)
    placed = []
    for instance_id, (ahead, left, heading) in enumerate(PLACES, start=1):
        T = seen_from(ahead + rng.uniform(-0.3, 0.3), heading + rng.uniform(-0.2, 0.2), height=0.6)
        T = T @ np.linalg.inv(nudge(yaw=heading)) @ nudge(y=left) @ nudge(yaw=heading)
        model = MODELS[1] if instance_id == len(PLACES) else MODELS[0]
        hull = cv2.convexHull(CAMERA.project(transform_points(T, box_corners(model.size))).astype(np.float32))
        amodal_mask = np.zeros((3 * CAMERA.height, 3 * CAMERA.width), np.uint8)
        shift = np.array([CAMERA.width, CAMERA.height])
        cv2.fillConvexPoly(amodal_mask, (hull[:, 0] + shift).round().astype(np.int32), 1)
        placed.append((T[2, 3], instance_id, model, T, amodal_mask.astype(bool)))
    window = slice(CAMERA.height, 2 * CAMERA.height), slice(CAMERA.width, 2 * CAMERA.width)
    for z, instance_id, _, _, amodal_mask in sorted(placed, key=lambda item: -item[0]):
        ids[amodal_mask[window]], depth[amodal_mask[window]] = instance_id, z
    rgb = np.stack([40 + 35 * ids, 90 + 10 * ids, 70 + 0 * ids], axis=-1).astype(np.uint8)
    annotations = [_annotate(item, ids, window) for item in sorted(placed, key=lambda item: item[1])]
    return Observation(
        scene, number, CAMERA, np.eye(4), {"camera": MountedReading(np.eye(4), RgbdReading(rgb, depth))},
        RenderBuffers(rgb, depth, ids),
        tuple(item for item in annotations if item.pixels_in_image),
    )  # fmt: skip


def _annotate(item, ids, window) -> ObjectAnnotation:
    _, instance_id, model, T, amodal_mask = item
    visible = ids == instance_id
    left, top, right, bottom = mask_box_xyxy(amodal_mask)
    offset = (left - CAMERA.width, top - CAMERA.height)
    amodal = (offset[0], offset[1], right - CAMERA.width, bottom - CAMERA.height)
    return ObjectAnnotation(
        instance_id, model.class_name, model.obj_id, T, model.size, amodal, mask_box_xyxy(visible), offset,
        amodal_mask[top : bottom + 1, left : right + 1], int(amodal_mask.sum()), int(amodal_mask[window].sum()),
        int(visible.sum()), int(visible.sum()), illuminance=100.0 * instance_id,
    )  # fmt: skip
