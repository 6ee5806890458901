from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.errors import one_line
from warehouse_sim.dataset.results.pose_csv import estimate_fault, require_estimates
from warehouse_sim.errors import InputError
from warehouse_sim.schema import PoseEstimate

GOOD = PoseEstimate(0, 1, 2, 0.5, np.eye(4))


def test_good_estimates_pass() -> None:
    assert estimate_fault(GOOD) is None
    assert estimate_fault(replace(GOOD, scene_id=np.int64(3), score=1)) is None
    assert require_estimates((GOOD,), "it") == [GOOD]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"scene_id": "0"}, "scene_id must be a whole number, found '0'"),
        ({"obj_id": 1.0}, "obj_id must be a whole number, found 1.0"),
        ({"score": float("nan")}, "score must be a finite number, found nan"),
        ({"score": 10**400}, "score must be a finite number, found 1000"),
        ({"error_bound": 1e300}, "error_bound must be a distance (m) or None, found 1e+300"),
        ({"covariance": np.full((6, 6), np.nan)}, "covariance must be a 6 x 6 array of finite numbers or None"),
        (
            {"T_camera_object": np.eye(4) + np.outer([1e9, 0, 0, 0], [0, 0, 0, 1])},
            "T_camera_object says that the object is 1,000,000,000 m away; give metres",
        ),
        ({"time": None}, "time must be a finite number, found None"),
        ({"name": 3}, "name and class_name must be text, found 3 and ''"),
        ({"T_camera_object": np.eye(3)}, "T_camera_object must be a 4 x 4 array"),
        ({"T_camera_object": 2 * np.eye(4)}, "T_camera_object must be a rotation and a translation (m)"),
        ({"T_camera_object": np.full((4, 4), np.nan)}, "T_camera_object must be a rotation and a translation (m)"),
    ],
)
def test_what_is_wrong_is_named(changes: dict[str, Any], words: str) -> None:
    with one_line(InputError, f"my estimator: estimate 1: {words}"):
        require_estimates([GOOD, replace(GOOD, **changes)], "my estimator")


@pytest.mark.parametrize("found", [None, 3, "poses", {"a": GOOD}, [3]])
def test_what_is_no_list_of_estimates_is_said(found: Any) -> None:
    with pytest.raises(InputError, match="must be a"):
        require_estimates(found, "my estimator")
