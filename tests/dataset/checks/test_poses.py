from dataclasses import replace

import numpy as np
import pytest

from tests.dataset.toy import CAMERA, CARTON, PALLET, cast_boxes
from warehouse_sim.dataset.checks.poses import amodal_mask_shift, comparable, mesh_depth
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.geometry.pose import make_transform, matrix_from_quat_wxyz
from warehouse_sim.schema import ObjectModel

LARGE = PinholeCamera(640, 480, 500.0, 500.0, 319.5, 239.5)


def amodal_mask(camera: PinholeCamera, offset_px: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    T_camera_object = make_transform(matrix_from_quat_wxyz(np.array([0.7, -0.6, 0.3, 0.2])), np.array([0.1, 0.0, 2.0]))
    moved = PinholeCamera(
        camera.width, camera.height, camera.fx, camera.fy, camera.cx + offset_px[0], camera.cy + offset_px[1]
    )
    return np.isfinite(mesh_depth(PALLET.mesh(), T_camera_object, moved))


@pytest.mark.parametrize("offset_px", [(0.0, 0.0), (0.3, 0.0), (0.0, -0.4), (-0.5, 0.25), (1.0, 0.0)])
def test_known_shift_is_measured(offset_px: tuple[float, float]) -> None:
    shift_px, _ = amodal_mask_shift(amodal_mask(LARGE, offset_px), amodal_mask(LARGE))
    assert np.abs(shift_px - offset_px).max() < 0.05


def test_large_shift_is_not_taken_for_a_small_one() -> None:
    shift_px, _ = amodal_mask_shift(amodal_mask(LARGE, (9.0, 0.0)), amodal_mask(LARGE))
    assert np.linalg.norm(shift_px) > 0.5


@pytest.mark.parametrize("camera", [CAMERA, LARGE])
def test_missing_or_swollen_mask_is_a_mismatch(camera: PinholeCamera) -> None:
    sampled = amodal_mask(camera)
    swollen = sampled | np.roll(sampled, 1, axis=0) | np.roll(sampled, -1, axis=0) | np.roll(sampled, 1, axis=1)
    assert amodal_mask_shift(sampled, sampled)[1] == 0.0
    assert amodal_mask_shift(np.zeros_like(sampled), sampled)[1] > 0.25
    assert amodal_mask_shift(swollen, sampled)[1] > 0.25


def test_beside_what_is_nearer_a_matched_window_is_not_believed() -> None:
    near, far, slope = 2.0, 3.0, np.linspace(2.0, 2.4, 100)
    visible = np.ones((40, 100), bool)
    step = np.where(np.arange(100) < 50, near, far) * np.ones((40, 1))
    assert np.flatnonzero(~comparable(visible, step, windows=True)[20]).tolist() == list(range(50, 60))
    assert comparable(visible, np.tile(slope, (40, 1)), windows=True).all()
    assert comparable(visible, step, windows=False).all()
    # A slit of 20 pixels, far behind, is read as what is before it from both sides.
    slit = np.where((np.arange(100) >= 40) & (np.arange(100) < 60), far, near) * np.ones((40, 1))
    assert np.flatnonzero(~comparable(visible, slit, windows=True)[20]).tolist() == list(range(40, 60))
    visible[:, :30] = False
    for windows, reach in ((True, 10), (False, 4)):
        assert np.flatnonzero(comparable(visible, np.full((40, 100), near), windows)[20])[0] == 30 + reach


@pytest.mark.parametrize(
    ("model", "lens"),
    [
        (PALLET, None),
        (CARTON, None),
        (PALLET, Distortion(k1=-0.3, k2=0.08, p1=0.002)),
        (PALLET, Distortion(k1=0.2, p2=0.003)),
    ],
    ids=["pallet", "carton", "barrel", "pincushion"],
)
@pytest.mark.parametrize("seed", range(5))
def test_depth_equals_that_of_a_ray_caster(model: ObjectModel, lens: Distortion | None, seed: int) -> None:
    rng = np.random.default_rng(seed)
    camera = replace(CAMERA, distortion=lens)
    R = matrix_from_quat_wxyz(rng.normal(size=4))
    T_camera_object = make_transform(R, rng.uniform([-1.0, -0.5, 1.2], [1.0, 0.5, 4.0]))
    expected = cast_boxes(model, T_camera_object, camera.rays())
    depth = mesh_depth(model.mesh(), T_camera_object, camera)
    assert np.array_equal(np.isfinite(depth), np.isfinite(expected))
    hit = np.isfinite(expected)
    assert hit.any()
    assert np.abs(depth[hit] - expected[hit]).max() < 1e-9


def test_mesh_at_the_lens_is_not_judged() -> None:
    assert mesh_depth(CARTON.mesh(), make_transform(None, np.array([0.0, 0.0, 0.1])), CAMERA) is None


def test_mesh_beside_the_image_covers_nothing() -> None:
    assert np.isinf(mesh_depth(CARTON.mesh(), make_transform(None, np.array([9.0, 0.0, 2.0])), CAMERA)).all()
