"""Point pair features (Drost et al., CVPR 2010) of opencv-contrib behind the door for programs.

They have an environment of their own, and no package of it enters that of warehouse-sim:

    python -m venv ppf && ppf/bin/pip install opencv-contrib-python-headless trimesh
    warehouse-sim predict --exec "ppf/bin/python examples/point_pair_features/program.py" --data DATA --out ppf.csv
    warehouse-sim bench warehouses --estimators "exec:ppf/bin/python examples/point_pair_features/program.py"

Each detection is matched with the CAD of each object of its class; the pose that most of its points lie near is kept.
"""

import json
import sys
from functools import cache
from typing import Any

import cv2
import numpy as np
import trimesh

STEP = 0.05
"""Sampling of model and scene, and width of the bins of distances, over the diameter of the model."""
REFERENCES = 0.2
"""Fraction of the scene's points that vote."""
MODEL_POINTS, SCENE_POINTS, NEIGHBOURS = 20_000, 2_000, 12
KEPT = 5
"""Poses that ICP refines."""
NEAR = 0.02
"""Points this near to the surface (fraction of the diameter) speak for a pose."""


@cache
def model_of(path: str) -> tuple[Any, np.ndarray]:
    """Return a trained detector of a mesh (mm), and points of its surface (m) with their normals, (n, 6)."""
    mesh = trimesh.load(path)
    mesh.apply_scale(0.001)
    points, faces = trimesh.sample.sample_surface(mesh, MODEL_POINTS, seed=0)
    cloud = thinned(np.hstack([points, mesh.face_normals[faces]]), STEP * float(np.linalg.norm(mesh.extents)))
    detector = cv2.ppf_match_3d_PPF3DDetector(STEP, STEP)
    detector.trainModel(cloud)
    return detector, cloud


def thinned(cloud: np.ndarray, edge: float) -> np.ndarray:
    """Return one point with its normal for each cube (m) that holds any: OpenCV samples flat objects too densely."""
    _, first = np.unique(np.floor(cloud[:, :3] / edge).astype(int), axis=0, return_index=True)
    return cloud[first].astype(np.float32)


def points_in(mask: np.ndarray, depth: np.ndarray, K: np.ndarray) -> np.ndarray:
    """Return points of a mask (camera frame, m) with normals that face the camera, (n, 6)."""
    v, u = np.nonzero(mask & (depth > 0))
    chosen = np.random.default_rng(0).permutation(len(u))[:SCENE_POINTS]
    u, v = u[chosen], v[chosen]
    rays = np.stack([u, v, np.ones(len(u))], axis=1) @ np.linalg.inv(K).T
    points = (rays * depth[v, u][:, None]).astype(np.float32)
    if len(points) < 10 * NEIGHBOURS:
        return np.empty((0, 6), np.float32)
    return cv2.ppf_match_3d.computeNormalsPC3d(points, NEIGHBOURS, True, (0.0, 0.0, 0.0))[1].astype(np.float32)


def best_pose(scene: np.ndarray, info: dict[str, Any]) -> tuple[float, np.ndarray]:
    """Return the pose of an object in a scene, and the fraction of the points that lie on it; 0 where nothing fits."""
    detector, cloud = model_of(info["mesh"])
    scene = thinned(scene, STEP * info["diameter"])
    found = detector.match(scene, REFERENCES, STEP)[:KEPT]
    if found:
        found = cv2.ppf_match_3d_ICP(50).registerModelToScene(cloud, scene, found)[1]
    seen = [item.pose for item in found if item.pose[2, 3] > 0.0]  # the rest lies behind the camera
    rated = [(fitness(scene, cloud, pose, info["diameter"]), pose) for pose in seen]
    return max(rated, key=lambda pair: pair[0], default=(0.0, np.eye(4)))


def fitness(scene: np.ndarray, cloud: np.ndarray, pose: np.ndarray, diameter: float) -> float:
    """Return the fraction of the scene's points that lie near a placed model."""
    inside = (scene[:, :3] - pose[:3, 3]) @ pose[:3, :3]
    index = cv2.flann_Index(np.ascontiguousarray(cloud[:, :3]), {"algorithm": 1, "trees": 1})
    _, squared = index.knnSearch(np.ascontiguousarray(inside.astype(np.float32)), 1)
    return float((squared < (NEAR * diameter) ** 2).mean())


def main() -> None:
    """Answer line by line, as docs/estimators.md states."""
    for line in sys.stdin:
        image = json.loads(line)
        depth = cv2.imread(image["depth"], cv2.IMREAD_UNCHANGED) * image["depth_scale"]
        for item in image["detections"]:
            mask = np.zeros(depth.shape, bool)
            if item["mask"]:
                mask = cv2.imread(item["mask"], cv2.IMREAD_UNCHANGED) > 0
            else:
                left, top, right, bottom = (max(int(edge), 0) for edge in item["box_xyxy"])
                mask[top : bottom + 1, left : right + 1] = True
            scene = points_in(mask, depth, np.array(image["K"]))
            cad = [info for info in image["objects"] if info["mesh"]]
            named = [info for info in cad if info["name"] == item["name"]]
            alike = named or [info for info in cad if info["class_name"] == item["class_name"]] or cad
            if len(scene) == 0 or not alike:
                continue
            fits = [(*best_pose(scene, info), info["obj_id"]) for info in alike]
            score, pose, obj_id = max(fits, key=lambda fit: fit[0])
            if score == 0.0:
                continue
            answer = {"detection": item["detection"], "obj_id": obj_id, "score": score}
            print(json.dumps(answer | {"R": pose[:3, :3].tolist(), "t": pose[:3, 3].tolist()}))
        print("", flush=True)


if __name__ == "__main__":
    main()
