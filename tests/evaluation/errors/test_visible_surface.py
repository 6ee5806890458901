"""VSD on images of a few pixels, whose rays have lengths that can be said with a pencil."""

import numpy as np
import pytest

from warehouse_sim.evaluation.errors.visible_surface import vsd
from warehouse_sim.geometry.camera import PinholeCamera

CAMERA = PinholeCamera(3, 1, 1.0, 1.0, 1.0, 0.0)
"""Its rays to z = 1 are as long as the square root of 2, 1 and the square root of 2."""
UNKNOWN = np.zeros((1, 3))


def depth(*values: float) -> np.ndarray:
    return np.array([values])


def test_surfaces_lie_apart_along_the_ray() -> None:
    # 0.9 m along the axis are 1.27 m along the outer rays: 9 % and 13 % of the diameter.
    found = vsd(depth(1.9, 1.9, 1.9), depth(1.0, 1.0, 1.0), UNKNOWN, CAMERA, 10.0, taus=(0.05, 0.1, 0.15))
    assert found == pytest.approx([1.0, 2 / 3, 0.0])


def test_what_stands_before_a_surface_hides_it_along_the_ray() -> None:
    # 12 mm before it along the axis are 17 mm along the outer rays, which is more than the tolerance of 15 mm.
    true, seen = depth(1.0, 1.0, 1.0), depth(0.988, 0.988, 0.988)
    assert vsd(depth(0.0, 5.0, 0.0), true, seen, CAMERA, 1.0, taus=(0.1,)) == pytest.approx([1.0])
    assert vsd(depth(1.0, 1.0, 1.0), true, seen, CAMERA, 1.0, taus=(0.1,)) == pytest.approx([0.0])
    assert vsd(depth(0.98, 1.0, 0.0), true, seen, CAMERA, 1.0, taus=(0.1,)) == pytest.approx([1 / 2])


def test_pixels_of_one_surface_alone_are_wrong() -> None:
    found = vsd(depth(1.0, 1.0, 0.0), depth(0.0, 1.0, 1.0), UNKNOWN, CAMERA, 1.0, taus=(0.1,))
    assert found == pytest.approx([2 / 3])
    assert vsd(UNKNOWN, UNKNOWN, UNKNOWN, CAMERA, 1.0) == pytest.approx(np.ones(10))
