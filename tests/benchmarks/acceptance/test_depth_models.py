"""The table of published curves, and that measuring on planes gives what went in."""

import numpy as np
import pytest

from benchmarks.acceptance.depth_curves import CURVES
from benchmarks.acceptance.depth_planes import MATERIALS, sigma_and_fill
from warehouse_sim.sensors.rgbd.depth import PRESETS
from warehouse_sim.sensors.rgbd.depth.quadratic import QuadraticDepth


def test_curves_belong_to_presets_within_their_range() -> None:
    for curve in CURVES:
        model = PRESETS[curve.preset]
        assert curve.material in MATERIALS
        assert all(model.min_range <= z <= model.max_range for z in curve.distances), curve.source
        assert all(np.isfinite(curve.value(z, 0.0)) for z in curve.distances)


@pytest.mark.parametrize(("z", "angle_deg"), [(1.0, 0.0), (3.0, 60.0)])
def test_a_known_sigma_is_measured(z: float, angle_deg: float) -> None:
    model = QuadraticDepth(sigma_base=0.003, sigma_quadratic=0.0)
    sigma, fill = sigma_and_fill(model, z, angle_deg, "kraft")
    assert sigma == pytest.approx(0.003, rel=0.1)
    assert fill == 1.0
