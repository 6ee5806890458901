"""An object that looks different from everywhere, a potato of metres, and its depth image at a known pose."""

from functools import cache
from pathlib import Path

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transform, make_transform, transform_points
from warehouse_sim.geometry.symmetry import SymmetryGroup

T_CAMERA_POTATO: Transform = make_transform(
    Rotation.from_euler("xyz", [100, 35, 20], degrees=True).as_matrix(), [0.1, 0.05, 1.8]
)
_CAMERA = PinholeCamera(320, 240, 300.0, 300.0, 159.5, 119.5)


@cache
def potato() -> ObjectInfo:
    """Return the object."""
    whole = trimesh.creation.icosphere(subdivisions=4, radius=0.4)
    rng, points = np.random.default_rng(0), np.asarray(whole.vertices)
    waves = [np.sin(points @ rng.normal(scale=8.0, size=3) + rng.uniform(0.0, 6.0)) for _ in range(6)]
    points = points * (1.0 + 0.08 * np.sum(waves, axis=0)[:, None]) * [1.0, 0.8, 0.6]
    mesh = TriangleMesh(points - (points.max(axis=0) + points.min(axis=0)) / 2.0, np.asarray(whole.faces))
    diameter = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    return ObjectInfo(
        obj_id=1, name="potato", class_name="pallet", size=np.ptp(mesh.vertices, axis=0), diameter=diameter,
        symmetry=SymmetryGroup(np.eye(4)[None]), pockets=(), root=Path(), read_mesh=lambda obj_id, even: mesh,
    )  # fmt: skip


def potato_image() -> RgbdImage:
    """Return what a camera without noise reads of it, with its mask."""
    mesh = potato().mesh()
    points, _ = trimesh.sample.sample_surface(trimesh.Trimesh(mesh.vertices, mesh.faces), 400_000, seed=0)
    seen = transform_points(T_CAMERA_POTATO, points)
    u, v = np.rint(_CAMERA.project(seen)).astype(int).T
    depth = np.full((_CAMERA.height, _CAMERA.width), np.inf)
    np.minimum.at(depth, (v, u), seen[:, 2])
    mask = np.isfinite(depth)
    return RgbdImage(
        _CAMERA, np.where(mask, depth, 0.0).astype(np.float32), (Detection(mask, 1),), scene_id=0, image_id=0
    )
