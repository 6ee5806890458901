import numpy as np
import pytest

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render.raster.projection import (
    NEAR,
    projected_bounds,
)

CAMERA = PinholeCamera(320, 240, 300.0, 280.0, 150.0, 130.0)


def bounds_of(centre: tuple[float, float, float], half: tuple[float, float, float]) -> tuple[float, ...] | None:
    one = np.ones(1)
    return projected_bounds(
        CAMERA, np.eye(3)[None], np.array([centre]), np.zeros((1, 3)), one[:, None] * np.array([half])
    )


def test_bounds_of_a_box_ahead_are_those_of_its_near_face() -> None:
    left, top, right, bottom = bounds_of((0.1, 0.2, 3.0), (0.4, 0.3, 1.0))
    assert (left, right) == pytest.approx((150 + 300 * -0.3 / 2, 150 + 300 * 0.5 / 2))
    assert (top, bottom) == pytest.approx((130 + 280 * -0.1 / 2, 130 + 280 * 0.5 / 2))


def test_a_box_through_the_near_plane_is_cut_there() -> None:
    left, top, right, bottom = bounds_of((0.0, 0.0, 0.5), (0.01, 0.01, 1.0))
    assert (left, right) == pytest.approx((150 - 300 * 0.01 / NEAR, 150 + 300 * 0.01 / NEAR))
    assert (top, bottom) == pytest.approx((130 - 280 * 0.01 / NEAR, 130 + 280 * 0.01 / NEAR))


def test_a_box_behind_has_no_bounds() -> None:
    assert bounds_of((0.0, 0.0, -2.0), (1.0, 1.0, 1.0)) is None
