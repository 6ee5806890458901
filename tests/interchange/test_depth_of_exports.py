"""Stored clean depth against rays of another program on the exported scene, through the written calibration."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
import trimesh
from trimesh.ray.ray_pyembree import RayMeshIntersector

from warehouse_sim.cli.main import main
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import load_recipe

_VIEWS = 4


def solids(path: Path) -> trimesh.Trimesh:
    """Return all that is opaque in a GLB file, in the z-up world of the datasets."""
    scene = trimesh.load_scene(path)
    placed = []
    for node in scene.graph.nodes_geometry:
        transform, name = scene.graph[node]
        mesh = scene.geometry[name]
        if isinstance(mesh, trimesh.Trimesh) and getattr(mesh.visual.material, "alphaMode", None) != "BLEND":
            placed.append(trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).apply_transform(transform))
    upright = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
    return trimesh.util.concatenate(placed).apply_transform(upright)


@pytest.mark.gl
@pytest.mark.slow
@pytest.mark.parametrize("name", ["dock_staging", "very_narrow_aisle", "block_storage", "selective_rack", "drive_in"])
def test_clean_depth_is_what_rays_meet(tmp_path: Path, name: str) -> None:
    few = {
        "scene": {"observations_per_scene": _VIEWS, "targets": ["pallet"]},
        "sensors": {"outputs": ["default", "clean"], "lidar": None},
    }
    data, exported = tmp_path / "data", tmp_path / "scene.glb"
    generate(load_recipe(name, few), data, GenerateConfig(scenes=1, seed=7341, formats=("bop",)))
    (tmp_path / f"{name}.yaml").write_text(
        f"extends: {name}\ndescription: few views\nscene: {json.dumps(few['scene'])}\n"
        f"sensors: {json.dumps(few['sensors'])}\n"
    )
    assert (
        main(["export-scene", str(tmp_path / f"{name}.yaml"), "--to", "glb", "--seed", "7341", "--out", str(exported)])
        == 0
    )
    mesh = solids(exported)
    rays = RayMeshIntersector(mesh, scale_to_box=False)
    (folder,) = data.glob("bop/*/000000")
    cameras = json.loads((folder / "scene_camera.json").read_text())
    assert len(cameras) == _VIEWS
    for number, camera in cameras.items():
        K = np.array(camera["cam_K"]).reshape(3, 3)
        R, t = np.array(camera["cam_R_w2c"]).reshape(3, 3), np.array(camera["cam_t_w2c"]) / 1000.0
        depth = cv2.imread(str(folder / "depth_clean" / f"{int(number):06d}.png"), cv2.IMREAD_UNCHANGED)
        depth = depth * camera["depth_scale"] / 1000.0
        v, u = np.mgrid[: depth.shape[0], : depth.shape[1]]
        local = np.stack([(u - K[0, 2]) / K[0, 0], (v - K[1, 2]) / K[1, 1], np.ones(u.shape)], axis=-1).reshape(-1, 3)
        triangle = rays.intersects_first(np.repeat([-R.T @ t], len(local), axis=0), local @ R)
        normal = mesh.face_normals[triangle]
        # Depth of the triangle's plane on the ray: exact, where float32 distances of hits are not.
        origin = -R.T @ t
        height = np.einsum("ij,ij->i", normal, mesh.triangles[triangle, 0] - origin)
        exact = (height / np.einsum("ij,ij->i", normal, local @ R)).reshape(depth.shape)
        met = (triangle >= 0).reshape(depth.shape)
        away = met & inside(triangle.reshape(depth.shape), normal.reshape(*depth.shape, 3), exact) & (depth > 0)
        assert away.mean() > 0.4
        off = np.abs(depth - exact)[away]
        assert (off < 0.0015 + 0.001 * exact[away]).mean() > 0.999  # half a millimetre is the file's own rounding


def inside(triangle: np.ndarray, normal: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """Return the pixels all of whose neighbours lie in one smooth surface with them."""
    found = np.zeros(depth.shape, bool)
    found[1:-1, 1:-1] = True
    inverse = 1.0 / np.maximum(depth, 1e-9)
    for axis in (0, 1):
        # Along a row or column of a plane, 1 / depth is linear.
        second = np.roll(inverse, 1, axis) - 2 * inverse + np.roll(inverse, -1, axis)
        found &= np.abs(second) < 1e-3 * inverse
    for shift in [(a, b) for a in (-1, 0, 1) for b in (-1, 0, 1)]:
        found &= np.einsum("hwc,hwc->hw", np.roll(normal, shift, (0, 1)), normal) > 0.999
    return found
