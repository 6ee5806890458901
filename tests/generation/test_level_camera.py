"""A tilted camera's KITTI files, refereed by rays, by a homography of BOP's image and by the devkit's projection."""

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from warehouse_sim.dataset.manifest import Manifest, read_manifest
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.dataset.validate import validate
from warehouse_sim.errors import DatasetError
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig, plan_dataset
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.render.raycaster import RayCaster

TEXT = """
extends: smoke
description: smoke, seen by a pitched and rolled camera
scene:
  viewpoints: {kind: post, pitch_deg: {min: -30, max: -12}, roll_deg: {min: -3, max: 3}}
  observations_per_scene: 3
sensors:
  outputs: [default, clean]
  camera: {width: 612, height: 185, focal_px: 360}
  right: {baseline: 0.3, matching: null}
  lidar: {range_noise: 0.0, laser_bias: 0.0, divergence_mrad: [0, 0]}
scenes: 1
split: {train: 1.0, val: 0.0, test: 0.0}
"""


def recipe(folder: Path, text: str = TEXT) -> Recipe:
    path = folder / "tilted.yaml"
    path.write_text(text)
    return load_recipe(str(path))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Recipe]:
    folder = tmp_path_factory.mktemp("tilted")
    generate(recipe(folder), folder / "data", GenerateConfig())
    return folder / "data", recipe(folder)


def kitti(root: Path, kind: str, frame: int) -> Path:
    return next((root / "kitti" / "training" / kind).glob(f"{frame:06d}.*"))


def calib(root: Path, frame: int) -> dict[str, np.ndarray]:
    """Read a calib file as the devkit does."""
    rows = dict(line.split(":") for line in kitti(root, "calib", frame).read_text().splitlines())
    return {key: np.array(row.split(), float).reshape(3, -1) for key, row in rows.items()}


def gt_camera(root: Path, frame: int) -> tuple[np.ndarray, np.ndarray]:
    """Return K and T_world_camera as BOP and the scene record have them."""
    scene = json.loads((root / "bop" / "train" / "000000" / "scene_camera.json").read_text())[str(frame)]
    record = json.loads((root / "scenes" / "000000.json").read_text())["observations"][frame]
    return np.reshape(scene["cam_K"], (3, 3)), np.reshape(record["T_world_camera"], (4, 4))


def level_axes(T_world_camera: np.ndarray) -> np.ndarray:
    """Return right, down and ahead of the level camera as columns, from cross products."""
    ahead = T_world_camera[:3, 2] * [1.0, 1.0, 0.0]
    ahead /= np.linalg.norm(ahead)
    down = np.array([0.0, 0.0, -1.0])
    return np.stack([np.cross(down, ahead), down, ahead], axis=1)


@pytest.fixture(scope="module")
def caster(made: tuple[Path, Recipe]) -> RayCaster:
    return RayCaster(prepare_scene(made[1], 0, 0).scene)


@pytest.mark.gl
def test_the_dataset_holds_its_checks_and_its_manifest_says_so(made) -> None:
    assert [check for check in validate(made[0]) if not check.ok] == []
    assert read_manifest(made[0]).contents.levelled == ("kitti",)
    assert "level virtual camera" in (made[0] / "kitti" / "README.md").read_text()


@pytest.mark.gl
@pytest.mark.parametrize("frame", [0, 1, 2])
def test_depth_is_what_rays_from_the_level_camera_meet(made, caster: RayCaster, frame: int) -> None:
    root, _ = made
    K, (_, T) = calib(root, frame)["P2"][:, :3], gt_camera(root, frame)
    steps = cv2.imread(str(kitti(root, "depth_clean_2", frame)), cv2.IMREAD_UNCHANGED)
    rng = np.random.default_rng(frame)
    u, v = rng.integers(0, steps.shape[1], 4000), rng.integers(0, steps.shape[0], 4000)
    rays = np.column_stack([u, v, np.ones(4000)]) @ np.linalg.inv(K).T @ level_axes(T).T
    hits = caster.cast(np.tile(T[:3, 3], (4000, 1)), rays)
    off = np.abs(steps[v, u] / 256.0 - np.where(np.isfinite(hits.distance), hits.distance, 0.0))
    assert np.mean(off < 0.5 / 256 + 1e-3) > 0.995


@pytest.mark.gl
@pytest.mark.parametrize("frame", [0, 1, 2])
def test_bops_image_warped_by_the_homography_is_kittis(made, frame: int) -> None:
    root, _ = made
    K_gt, T = gt_camera(root, frame)
    H = calib(root, frame)["P2"][:, :3] @ level_axes(T).T @ T[:3, :3] @ np.linalg.inv(K_gt)
    level = cv2.imread(str(kitti(root, "image_clean_2", frame)), cv2.IMREAD_GRAYSCALE)
    true = cv2.imread(str(root / "bop" / "train" / "000000" / "rgb_clean" / f"{frame:06d}.png"), cv2.IMREAD_GRAYSCALE)
    size = level.shape[::-1]
    warped = cv2.warpPerspective(true, H, size)
    inside = cv2.erode(cv2.warpPerspective(np.full_like(true, 255), H, size), np.ones((9, 9))) == 255
    assert inside.mean() > 0.5
    shifts = [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)]
    off = [np.abs(np.roll(warped, shift, (0, 1)).astype(float) - level)[inside].mean() for shift in shifts]
    assert off[0] < 2.0
    assert off[0] == min(off)  # a pixel aside in any direction, they agree less


@pytest.mark.gl
@pytest.mark.parametrize("frame", [0, 1, 2])
def test_boxes_and_points_project_onto_what_they_are_of(made, frame: int) -> None:
    root, _ = made
    numbers, depth = calib(root, frame), cv2.imread(str(kitti(root, "depth_clean_2", frame)), cv2.IMREAD_UNCHANGED)
    for line in kitti(root, "label_2", frame).read_text().splitlines():
        words = line.split()
        left, top, right, bottom, height, width, length, x, y, z, turn = map(float, words[4:15])
        signs = np.array([[a, b, c] for a in (-0.5, 0.5) for b in (-1.0, 0.0) for c in (-0.5, 0.5)])
        corners = signs * [length, height, width]
        R = np.array([[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]])
        shown = (corners @ R.T + [x, y, z]) @ numbers["P2"][:, :3].T
        u, v = (shown[:, :2] / shown[:, 2:]).T
        box = np.clip([u.min(), v.min(), u.max(), v.max()], 0, [*depth.shape[::-1]] * 2)
        # An EPAL pallet fills its box: the outline of its corners is that of its amodal mask.
        assert np.abs(box - [left, top, right, bottom]).max() < 4.0, line
    cloud = np.fromfile(kitti(root, "velodyne", frame), "<f4").reshape(-1, 4)[:, :3]
    seen = cloud @ numbers["Tr_velo_to_cam"][:, :3].T + numbers["Tr_velo_to_cam"][:, 3]
    u, v = (seen[:, :2] / seen[:, 2:] @ np.diag(numbers["P2"][[0, 1], [0, 1]]) + numbers["P2"][:2, 2]).T
    inside = (seen[:, 2] > 0) & (u > 0) & (v > 0) & (u < depth.shape[1] - 1) & (v < depth.shape[0] - 1)
    read = depth[np.rint(v[inside]).astype(int), np.rint(u[inside]).astype(int)] / 256.0
    assert inside.sum() > 1000
    assert np.median(np.abs(read - seen[inside, 2])) < 0.01
    # The LiDAR stands upright, so that nothing of it leans in the level frame.
    np.testing.assert_allclose(numbers["Tr_velo_to_cam"][:, 2], [0.0, -1.0, 0.0], atol=1e-9)


@pytest.mark.gl
def test_the_right_camera_is_level_too(made) -> None:
    root, _ = made
    sizes = {kind: cv2.imread(str(kitti(root, kind, 0))).shape for kind in ("image_2", "image_3", "image_clean_3")}
    assert len(set(sizes.values())) == 1
    P2, P3 = calib(root, 0)["P2"], calib(root, 0)["P3"]
    assert P3[0, 3] == pytest.approx(-0.3 * P2[0, 0])


def planned(folder: Path, views: str, more: str = "") -> Manifest:
    text = f"extends: smoke\ndescription: tilted\nscene:\n  viewpoints: {views}\n{more}"
    return plan_dataset(recipe(folder, text), GenerateConfig(formats=("kitti",))).manifest


REJECTED = [
    ("{kind: ceiling}", "", "ceiling shows what lies 1.. deg from the horizon"),
    ("{kind: free}", "", "free shows what lies 74 deg"),
    ("{kind: post, pitch_deg: -46}", "", "post shows what lies 60 deg"),
    ("{kind: post, pitch_deg: {mean: -30, std: 9, min: -50, max: 0}}", "", "post shows what lies 64 deg"),
    ("{kind: {choices: [level, post]}}", "sensors: {camera: {width: 800, height: 800, focal_px: 400}}", "75 deg"),
]


@pytest.mark.parametrize(("views", "more", "message"), REJECTED)
def test_views_beyond_60_deg_are_rejected_at_planning(tmp_path: Path, views: str, more: str, message: str) -> None:
    with pytest.raises(DatasetError, match=message) as caught:
        DatasetStore(tmp_path / "data", planned(tmp_path, views, more))
    assert str(caught.value).startswith("KITTI: ")
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "data").exists()


@pytest.mark.parametrize("kind", ["post", "forklift_mast", "forklift_forks", "forklift_guard", "amr"])
def test_cameras_as_they_are_mounted_are_taken(tmp_path: Path, kind: str) -> None:
    manifest = planned(tmp_path, f"{{kind: {kind}, roll_deg: {{min: -3, max: 3}}}}")
    assert manifest.contents.levelled == ("kitti",)
    assert 0.0 < manifest.contents.view_angle_deg < 60.0
    assert DatasetStore(tmp_path / "data", manifest).manifest is manifest


def test_a_level_recipe_has_no_virtual_camera(tmp_path: Path) -> None:
    contents = planned(tmp_path, "{kind: amr, level: true}").contents
    assert (contents.levelled, contents.view_angle_deg) == ((), 0.0)
    both = replace(GenerateConfig(), formats=("bop",))
    tilted = recipe(tmp_path, "extends: smoke\ndescription: t\nscene: {viewpoints: {kind: ceiling}}\n")
    assert plan_dataset(tilted, both).manifest.contents.levelled == ()
