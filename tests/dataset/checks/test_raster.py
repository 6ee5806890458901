from dataclasses import replace

import numpy as np
import pytest

from tests.dataset.toy import CAMERA, CARTON, PALLET, cast_boxes
from warehouse_sim.dataset.checks.poses import mesh_depth
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.geometry.pose import make_transform, matrix_from_quat_wxyz


@pytest.mark.parametrize("model", [PALLET, CARTON], ids=lambda model: model.name)
@pytest.mark.parametrize("seed", range(5))
def test_depth_equals_that_of_a_ray_caster(model, seed: int) -> None:
    rng = np.random.default_rng(seed)
    R = matrix_from_quat_wxyz(rng.normal(size=4))
    T_camera_object = make_transform(R, rng.uniform([-1.0, -0.5, 1.2], [1.0, 0.5, 4.0]))
    expected = cast_boxes(model, T_camera_object, CAMERA.rays())
    depth = mesh_depth(model.mesh(), T_camera_object, CAMERA)
    assert np.array_equal(np.isfinite(depth), np.isfinite(expected))
    hit = np.isfinite(expected)
    assert hit.any()
    assert np.abs(depth[hit] - expected[hit]).max() < 1e-9


@pytest.mark.parametrize(
    "lens", [Distortion(k1=-0.3, k2=0.08, p1=0.002), Distortion(k1=0.2, p2=0.003)], ids=["barrel", "pincushion"]
)
@pytest.mark.parametrize("seed", range(5))
def test_behind_a_lens_depth_equals_that_along_its_rays(lens: Distortion, seed: int) -> None:
    rng = np.random.default_rng(seed)
    camera = replace(CAMERA, distortion=lens)
    R = matrix_from_quat_wxyz(rng.normal(size=4))
    T_camera_object = make_transform(R, rng.uniform([-1.0, -0.5, 1.2], [1.0, 0.5, 4.0]))
    expected = cast_boxes(PALLET, T_camera_object, camera.rays())
    depth = mesh_depth(PALLET.mesh(), T_camera_object, camera)
    assert np.array_equal(np.isfinite(depth), np.isfinite(expected))
    hit = np.isfinite(expected)
    assert hit.any()
    assert np.abs(depth[hit] - expected[hit]).max() < 1e-9


def test_mesh_at_the_lens_is_not_judged() -> None:
    assert mesh_depth(CARTON.mesh(), make_transform(None, np.array([0.0, 0.0, 0.1])), CAMERA) is None


def test_mesh_beside_the_image_covers_nothing() -> None:
    assert np.isinf(mesh_depth(CARTON.mesh(), make_transform(None, np.array([9.0, 0.0, 2.0])), CAMERA)).all()
