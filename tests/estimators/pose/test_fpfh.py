"""Features of points and fast global registration find an object that noise does not hide."""

import sys

import numpy as np
import pytest

from tests.estimators.pose.potato import T_CAMERA_POTATO, potato, potato_image
from warehouse_sim.errors import MissingPackageError
from warehouse_sim.estimators.pose.fpfh import FpfhFgr
from warehouse_sim.geometry.pose import transform_points


def test_it_finds_an_object_without_symmetry_and_answers_twice_alike() -> None:
    pytest.importorskip("open3d")
    estimator = FpfhFgr()
    estimator.onboard({1: potato()})
    (found,), (again,) = estimator.estimate(potato_image()), estimator.estimate(potato_image())
    points = potato().mesh().vertices
    off = transform_points(found.T_camera_object, points) - transform_points(T_CAMERA_POTATO, points)
    assert np.linalg.norm(off, axis=1).mean() < 0.05 * potato().diameter
    assert found.score > 0.8
    assert found.time > 0.0
    np.testing.assert_array_equal(found.T_camera_object, again.T_camera_object)


def test_without_open3d_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "open3d", None)
    with pytest.raises(MissingPackageError, match=r"warehouse-sim\[open3d\]"):
        FpfhFgr()
