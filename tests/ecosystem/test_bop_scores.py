"""bop_toolkit measures and scores the same estimates; the numbers must be ours to 1e-6."""

import json
import os
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import KDTree

from tests.evaluation.made_dataset import make_dataset
from tests.evaluation.pallet import random_motion
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.evaluation.bop_scores import bop_scores
from warehouse_sim.evaluation.errors.pose_error import add, add_s, estimates_in_object, mspd, mssd
from warehouse_sim.evaluation.errors.surface import ErrorModels
from warehouse_sim.evaluation.errors.visible_surface import BOP_DELTA, BOP_TAUS, depth_of, vsd
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import PoseEstimate

from .conftest import RunTool

pytestmark = pytest.mark.ecosystem


@pytest.fixture(scope="module")
def toolkit() -> Path:
    folder = os.environ.get("WAREHOUSE_SIM_BOP_TOOLKIT")
    if not folder or not Path(folder).is_dir():
        pytest.skip("WAREHOUSE_SIM_BOP_TOOLKIT names no folder of github.com/thodan/bop_toolkit")
    return Path(folder)


def noisy(reader: DatasetReader, rng: np.random.Generator) -> list[PoseEstimate]:
    """From good to hopeless, some twice, some missing, scores in steps so that there are ties."""
    found = []
    for image in reader.images("test"):
        for target in image.targets:
            for _ in range(rng.integers(0, 4)):
                size = rng.choice([0.003, 0.01, 0.1, 0.6])
                T = target.T_camera_object @ random_motion(rng, size, size)
                score = float(rng.integers(0, 40)) / 40.0
                found.append(PoseEstimate(image.scene_id, image.image_id, target.obj_id, score, T))
    return found


def pose(T: np.ndarray) -> dict:
    return {"R": T[:3, :3].ravel().tolist(), "t": (1000.0 * T[:3, 3]).tolist()}


def case_of(reader: DatasetReader, estimates: list[PoseEstimate]) -> dict:
    models = {}
    for obj_id, info in reader.objects.items():
        symmetries = info.symmetry.transforms.copy()
        symmetries[:, :3, 3] *= 1000.0
        models[obj_id] = {
            "points": (1000.0 * info.model_points()).tolist(),
            "diameter": 1000.0 * info.diameter,
            "symmetries": symmetries.tolist(),
        }
    images = []
    for image in reader.images("test"):
        mine = [e for e in estimates if (e.scene_id, e.image_id) == (image.scene_id, image.image_id)]
        images.append(
            {
                "scene_id": image.scene_id,
                "im_id": image.image_id,
                "K": image.camera.K.tolist(),
                "width": image.camera.width,
                "ground_truths": [
                    {"obj_id": t.obj_id, "visib_fract": t.visible_fraction, **pose(t.T_camera_object)}
                    for t in image.targets
                ],
                "estimates": [{"obj_id": e.obj_id, "score": e.score, **pose(e.T_camera_object)} for e in mine],
            }
        )
    return {"models": models, "images": images}


@pytest.mark.parametrize("seed", [0, 1])
def test_errors_and_scores_are_those_of_bop_toolkit(
    tmp_path: Path, toolkit: Path, run_tool: RunTool, seed: int
) -> None:
    folder = os.environ.get("WAREHOUSE_SIM_BOP_DATA")
    reader = DatasetReader(Path(folder) if folder else make_dataset(tmp_path / "data"))
    estimates = noisy(reader, np.random.default_rng(seed))
    case = case_of(reader, estimates)
    (tmp_path / "case.json").write_text(json.dumps(case))
    theirs = json.loads(run_tool("bop_scores.py", toolkit, tmp_path / "case.json"))
    assert len(theirs["errors"]) > 20
    images = {(image.scene_id, image.image_id): image for image in reader.images("test")}
    for row in theirs["errors"]:
        image = images[tuple(row["image"])]
        mine = [e for e in estimates if (e.scene_id, e.image_id) == (image.scene_id, image.image_id)]
        T, target = mine[row["estimate"]].T_camera_object[None], image.targets[row["gt"]]
        info, true = reader.objects[target.obj_id], target.T_camera_object[None]
        points = info.model_points()
        alike, alone = (estimates_in_object(T, true, group) for group in (info.symmetry, SymmetryGroup.trivial()))
        if row["mssd"] is not None:
            assert mssd(alike, points).min() * 1000.0 == pytest.approx(row["mssd"], abs=1e-6)
        assert add(alone, points)[0, 0] * 1000.0 == pytest.approx(row["add"], abs=1e-6)
        assert add_s(alone[:, 0], points, KDTree(points))[0] * 1000.0 == pytest.approx(row["adi"], abs=1e-6)
        assert mspd(T, true, info.symmetry, image.camera.K[None], points)[0] == pytest.approx(row["mspd"], rel=1e-9)
    ours = bop_scores(estimates, reader.images("test"), ErrorModels(reader.objects, 1))
    for name in ("ar_mssd", "ar_mspd", "ap_mssd", "ap_mspd", "ap_mssd_mm"):
        assert 0.0 < theirs[name] < 1.0
        assert getattr(ours, name) == pytest.approx(theirs[name], abs=1e-6)


def test_vsd_is_that_of_bop_toolkit_on_the_same_depth_images(tmp_path: Path, toolkit: Path, run_tool: RunTool) -> None:
    rng = np.random.default_rng(8)
    camera = PinholeCamera(60, 40, 50.0, 55.0, 29.0, 20.5)
    plane = 2.0 + 0.3 * np.linspace(0, 1, 60)[None] + rng.normal(0.0, 0.004, (40, 60))
    true, estimated = np.zeros((2, 40, 60))
    true[8:30, 10:40] = plane[8:30, 10:40]
    estimated[10:34, 14:44] = plane[10:34, 14:44] + rng.normal(0.05, 0.2, (24, 30))
    seen = plane + rng.choice([0.0, 0.01, -0.3], (40, 60))
    seen[rng.random((40, 60)) < 0.2] = 0.0
    case = {
        "models": {},
        "images": [],
        "depths": {k: (1000.0 * v).tolist() for k, v in (("true", true), ("estimated", estimated), ("seen", seen))},
        "depth_K": camera.K.tolist(),
        "delta": 1000.0 * BOP_DELTA,
        "taus": BOP_TAUS,
        "diameter": 1449.0,
    }
    (tmp_path / "case.json").write_text(json.dumps(case))
    theirs = json.loads(run_tool("bop_scores.py", toolkit, tmp_path / "case.json"))["vsd"]
    ours = vsd(estimated, true, seen, camera, 1.449)
    assert len(set(theirs)) > 3
    assert ours == pytest.approx(theirs, abs=1e-6)


def test_recall_by_vsd_is_that_of_bop_toolkit_on_the_same_depth_images(
    tmp_path: Path, toolkit: Path, run_tool: RunTool
) -> None:
    reader = DatasetReader(make_dataset(tmp_path / "data"))
    estimates = noisy(reader, np.random.default_rng(5))
    maps = {}
    for image in reader.images("test"):
        place = f"{image.scene_id}_{image.image_id}"
        maps[f"seen_{place}"] = 1000.0 * reader.depth(image)
        for number, target in enumerate(image.targets):
            mesh = reader.objects[target.obj_id].mesh()
            maps[f"gt_{place}_{number}"] = 1000.0 * depth_of(mesh, target.T_camera_object, image.camera)
        mine = [e for e in estimates if (e.scene_id, e.image_id) == (image.scene_id, image.image_id)]
        for number, item in enumerate(mine):
            mesh = reader.objects[item.obj_id].mesh()
            maps[f"estimate_{place}_{number}"] = 1000.0 * depth_of(mesh, item.T_camera_object, image.camera)
    np.savez(tmp_path / "maps.npz", **maps)
    case = case_of(reader, estimates)
    case |= {"maps": str(tmp_path / "maps.npz"), "delta": 1000.0 * BOP_DELTA, "taus": BOP_TAUS}
    (tmp_path / "case.json").write_text(json.dumps(case))
    theirs = json.loads(run_tool("bop_scores.py", toolkit, tmp_path / "case.json"))
    assert len({error for row in theirs["errors"] for error in row["vsd"]}) > 20
    ours = bop_scores(estimates, reader.images("test"), ErrorModels(reader.objects, 1), seen=reader.depth)
    assert 0.0 < theirs["ar_vsd"] < 1.0
    assert ours.ar_vsd == pytest.approx(theirs["ar_vsd"], abs=1e-6)
