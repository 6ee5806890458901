"""A BOP folder as MR6D is one: Euro pallets, carriers and a bin in a room, an Intel D435i, poses of motion capture.

Models are in millimetres, one with its origin on the floor, poses are off by the millimetres of the tracking, images
are JPEG, depth is noisy with holes. What BOP lets a folder leave out is left out: the world, lists of targets,
models_eval, and in one scene masks, in the other the table of boxes.
"""

import json
from pathlib import Path

import cv2
import numpy as np

from warehouse_sim.catalog.loads.cartons import SKUS, carton
from warehouse_sim.catalog.pallets import pallet
from warehouse_sim.dataset.files.ply import write_ply
from warehouse_sim.evaluation.errors.visible_surface import depth_of
from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transform, invert, make_transform, rotation_z

CAMERA = PinholeCamera(640, 480, 615.0, 615.2, 321.5, 238.7)
OBJECTS = {1: pallet("epal1"), 3: carton("carton_600x400x320"), 7: carton(sorted(SKUS)[0])}
"""Numbers with gaps, as in a folder of several makers."""
ON_FLOOR = 7
PLACES = (
    [(1, 2.6, 0.1, 0.4), (3, 3.4, -0.9, 0.9), (7, 2.0, 0.8, 0.2)],
    [(1, 3.2, -0.4, -0.7), (1, 4.6, 1.0, 1.4), (3, 2.2, 0.7, 0.1)],
)
"""Object, distance ahead, offset to the left (m), heading (rad), scene by scene."""
HEIGHT = 0.6
"""Of the camera over the floor (m)."""


def shape(obj_id: int) -> TriangleMesh:
    """Return a model (m); that of the small box has its origin on the floor below its middle."""
    surface = OBJECTS[obj_id].mesh()
    low = surface.vertices[:, 2].min() if obj_id == ON_FLOOR else 0.0
    return TriangleMesh(surface.vertices - [0.0, 0.0, low], surface.faces)


def write_room(root: Path) -> Path:
    """Write the folder and return it."""
    models = root / "models"
    models.mkdir(parents=True)
    table = {}
    for obj_id in OBJECTS:
        mesh = shape(obj_id)
        in_mm = TriangleMesh(1000.0 * mesh.vertices, mesh.faces)
        write_ply(models / f"obj_{obj_id:06d}.ply", in_mm)
        low, size = in_mm.vertices.min(axis=0), np.ptp(in_mm.vertices, axis=0)
        row = {f"min_{axis}": float(value) for axis, value in zip("xyz", low, strict=True)}
        row |= {f"size_{axis}": float(value) for axis, value in zip("xyz", size, strict=True)}
        half_turn = make_transform(rotation_z(np.pi)).ravel().tolist()
        table[obj_id] = row | {"diameter": float(np.linalg.norm(size)), "symmetries_discrete": [half_turn]}
    (models / "models_info.json").write_text(json.dumps(table))
    for number, places in enumerate(PLACES):
        _write_scene(root / "test" / f"{number:06d}", places, number)
    return root


def _seen_from(obj_id: int, ahead: float, left: float, heading: float) -> Transform:
    """Return the pose of an object on the floor in the frame of a level camera."""
    up = -float(shape(obj_id).vertices[:, 2].min())
    T_world_camera = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, HEIGHT], [0, 0, 0, 1]])
    return invert(T_world_camera) @ make_transform(rotation_z(heading), np.array([ahead, left, up]))


def _write_scene(folder: Path, places: list[tuple[int, float, float, float]], number: int) -> None:
    rng = np.random.default_rng(number)
    for name in ("rgb", "depth", *(("mask_visib", "mask") if number else ())):
        (folder / name).mkdir(parents=True)
    cameras, labels, infos = {}, {}, {}
    for image in (1, 5):  # frames of a recording that were kept
        poses = [_seen_from(obj, ahead + 0.1 * image, left, heading) for obj, ahead, left, heading in places]
        depths = [depth_of(shape(obj), T, CAMERA) for (obj, *_), T in zip(places, poses, strict=True)]
        nearest = _floor()
        for depth in depths:
            nearest = np.where((depth > 0) & ((depth < nearest) | (nearest == 0)), depth, nearest)
        masks = [(depth > 0) & (depth == nearest) for depth in depths]
        _write_image(folder, image, nearest, rng)
        cameras[image] = {"cam_K": CAMERA.K.ravel().tolist(), "depth_scale": 1.0}
        labels[image], infos[image] = [], []
        for index, ((obj, *_), T, mask, depth) in enumerate(zip(places, poses, masks, depths, strict=True)):
            off = make_transform(rotation_z(rng.normal(0.0, 0.001)), rng.normal(0.0, 0.002, 3))
            R, t = (T @ off)[:3, :3].round(6).ravel().tolist(), (1000.0 * (T @ off)[:3, 3]).tolist()
            labels[image].append({"obj_id": obj, "cam_R_m2c": R, "cam_t_m2c": t})
            left, top, right, bottom = mask_box_xyxy(mask) or (0, 0, 0, 0)
            box = [left, top, right - left, bottom - top]
            fraction = float(mask.sum() / max((depth > 0).sum(), 1))
            infos[image].append({"bbox_obj": box, "bbox_visib": box, "visib_fract": fraction})
            if number:
                for kind in ("mask_visib", "mask"):
                    seen = mask if kind == "mask_visib" else depth > 0
                    cv2.imwrite(str(folder / kind / f"{image:06d}_{index:06d}.png"), 255 * seen.astype(np.uint8))
    tables = {"camera": cameras, "gt": labels} | ({} if number else {"gt_info": infos})
    for name, table in tables.items():
        (folder / f"scene_{name}.json").write_text(json.dumps(table))


def _floor() -> np.ndarray:
    """Return the depth (m) of the floor and of a wall 7 m ahead."""
    v = np.arange(CAMERA.height)[:, None] - CAMERA.cy
    floor = np.where(v > 0, HEIGHT * CAMERA.fy / np.maximum(v, 1e-9), 7.0)
    return np.broadcast_to(np.minimum(floor, 7.0), (CAMERA.height, CAMERA.width)).copy()


def _write_image(folder: Path, image: int, depth: np.ndarray, rng: np.random.Generator) -> None:
    noisy = depth + rng.normal(0.0, 1.0, depth.shape) * 0.001 * depth**2
    noisy[rng.random(depth.shape) < 0.03] = 0.0
    cv2.imwrite(str(folder / "depth" / f"{image:06d}.png"), np.rint(1000.0 * noisy).astype(np.uint16))
    shade = np.clip(220.0 - 25.0 * depth, 20.0, 255.0)
    colour = np.repeat(shade[..., None], 3, axis=2) * [0.6, 0.8, 1.0]
    cv2.imwrite(str(folder / "rgb" / f"{image:06d}.jpg"), colour.astype(np.uint8))
