"""Point pair features of opencv-contrib answer through the door for programs, from an environment of their own."""

import os
from pathlib import Path

import numpy as np
import pytest

from tests.estimators.pose.potato import T_CAMERA_POTATO, potato, potato_image
from warehouse_sim.estimators.own.program import ProgramEstimator
from warehouse_sim.geometry.pose import transform_points

SCRIPT = Path(__file__).parents[2] / "examples" / "point_pair_features" / "program.py"


@pytest.mark.ecosystem
def test_they_find_an_object_by_the_cad_that_the_door_hands_out() -> None:
    python = os.environ.get("WAREHOUSE_SIM_PPF")
    if not python:
        pytest.skip("WAREHOUSE_SIM_PPF names no Python with opencv-contrib; `make test-ecosystem` makes one")
    estimator = ProgramEstimator(f"{python} {SCRIPT}")
    try:
        estimator.onboard({1: potato()})
        (found,) = estimator.estimate(potato_image())
    finally:
        estimator.close()
    points = potato().mesh().vertices
    off = transform_points(found.T_camera_object, points) - transform_points(T_CAMERA_POTATO, points)
    assert np.linalg.norm(off, axis=1).mean() < 0.1 * potato().diameter
    assert (found.obj_id, found.detection) == (1, 0)
    assert found.score > 0.5
