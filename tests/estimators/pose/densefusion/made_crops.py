"""Crops whose every number is known: what a camera sees of one pallet alone, sampled from its CAD surface."""

from dataclasses import replace
from functools import cache

import numpy as np

from tests.dataset.toy import PALLET
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import CropSet, stack_crops
from warehouse_sim.estimators.pose.densefusion.crops.cut import Crop
from warehouse_sim.estimators.pose.densefusion.crops.surround import Surroundings
from warehouse_sim.estimators.pose.densefusion.objects import ObjectShape
from warehouse_sim.estimators.pose.densefusion.settings import CropConfig
from warehouse_sim.geometry.mesh import diameter, sample_surface
from warehouse_sim.geometry.pose import invert, make_transform, rotation_y, rotation_z, transform_points

MESH = PALLET.mesh()
DIAMETER = diameter(MESH.vertices)
# Pallet x ahead, y left, z up, for a camera with x right, y down, z ahead.
UPRIGHT = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])


@cache
def pallet_shape() -> ObjectShape:
    """The pallet as a run folder keeps it, its moments from many samples."""
    points, _ = sample_surface(MESH, 100_000, np.random.default_rng(1))
    symmetries = tuple(tuple(map(float, T.ravel())) for T in PALLET.symmetry.transforms)
    covariance = tuple(map(float, np.cov(points.T, bias=True).ravel()))
    return ObjectShape(1, "toy-pallet", DIAMETER, tuple(map(float, points.mean(axis=0))), covariance, symmetries)


def pose(rng: np.random.Generator) -> np.ndarray:
    """A pallet somewhere ahead of the camera, turned by up to half a right angle."""
    place = np.array([rng.uniform(-1, 1), rng.uniform(0.2, 1), rng.uniform(2.5, 5)])
    return make_transform(rotation_y(rng.uniform(-0.4, 0.4)) @ UPRIGHT @ rotation_z(rng.uniform(-0.4, 0.4)), place)


def seen_points(T_camera_object: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
    """Points of the faces that are turned to the camera, in the camera frame."""
    points, normals = sample_surface(MESH, 4 * count + 200, rng)
    towards = ((invert(T_camera_object)[:3, 3] - points) * normals).sum(axis=1) > 0
    return transform_points(T_camera_object, points[towards][:count]).astype(np.float32)


def made_crop(
    rng: np.random.Generator, side_px: int | None = None, count: int = 400, depth: bool = False, obj_id: int = 1
) -> Crop:
    """One crop; its colours are noise that a network can tell apart, its depth an image of points about the true z."""
    T = pose(rng)
    points = seen_points(T, count, rng)
    side = side_px or 1
    z = rng.normal(T[2, 3], 0.3, (side, side)).astype(np.float32)
    return Crop(
        scene_id=0,
        image_id=0,
        position=0,
        obj_id=obj_id,
        T_camera_object=T,
        points=points,
        border_px=rng.integers(1, 9, len(points)).astype(np.uint8),
        pixel=rng.integers(0, side * side, len(points)).astype(np.int32),
        rgb=rng.integers(0, 256, (side, side, 3), dtype=np.uint8) if side_px else None,
        depth=np.where(rng.random(z.shape) < 0.1, np.float32(0), z) if side_px and depth else None,
        ray_map=np.array([[0.01, 0.0, -0.2], [0.0, 0.01, -0.1]]) if side_px and depth else None,
    )


def with_surroundings(crop: Crop, rng: np.random.Generator, others: int = 200, side_px: int = 80) -> Crop:
    """The crop with points of a wall behind and beside the object, which the mask does not hold."""
    places = crop.points[rng.integers(len(crop.points), size=others)] * rng.uniform(1.05, 1.2, (others, 1))
    points = np.concatenate([crop.points, places]).astype(np.float32)
    belongs = np.arange(len(points)) < len(crop.points)
    order = rng.permutation(len(points))
    uv = np.rint(600.0 * points[:, :2] / points[:, 2:])
    uv = np.clip(uv - uv[belongs].min(axis=0) + 100, 0, 399)
    around = Surroundings(
        np.where(belongs, 5, -5).astype(np.int8)[order],
        belongs[order],
        np.where(belongs, 0, 1).astype(np.uint8)[order],
        uv[order].astype(np.int16),
        400,
        rng.integers(-9, 9, (side_px, side_px)).astype(np.int8),
    )
    zeros = np.zeros(len(points))
    return replace(
        crop, points=points[order], border_px=zeros.astype(np.uint8), pixel=zeros.astype(np.int32), around=around
    )


def made_set(count: int, side_px: int | None = None, seed: int = 0, depth: bool = False, rgb: bool = True) -> CropSet:
    """A few crops as tensors."""
    rng = np.random.default_rng(seed)
    config = CropConfig(side_px=side_px, rgb=rgb or not depth, depth=depth, stored_points=400)
    return stack_crops([made_crop(rng, side_px, depth=depth) for _ in range(count)], [pallet_shape()], config)
