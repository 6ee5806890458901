"""Depth presets against published curves of sigma and fill, and that measuring on planes gives what went in."""

import json

import numpy as np
import pytest

from benchmarks.speed.result import RESULTS
from tests.sensors.rgbd.depth.curves import CURVES, Curve
from tests.sensors.rgbd.depth.planes import MATERIALS, sigma_and_fill
from warehouse_sim.sensors.rgbd.depth import PRESETS
from warehouse_sim.sensors.rgbd.depth.model import QuadraticDepth

STORED = {row["value"] for row in json.loads((RESULTS / "depth_models.json").read_text())["rows"] if "kind" in row}
"""The worst residual of each curve, as docs/sensors.md tells it."""


def residual(curve: Curve, read: float | None, published: float) -> float:
    """Return read less published, as a fraction where it is a length; of a bound only what exceeds it."""
    if read is None:
        return 1.0
    if curve.quantity == "fill":
        return read - published
    off = read / published - 1.0
    return max(off, 0.0) if curve.quantity == "bound" else off


@pytest.mark.slow
@pytest.mark.parametrize("curve", CURVES, ids=lambda curve: f"{curve.preset} {curve.quantity} {curve.source[:20]}")
def test_presets_read_what_is_published(curve: Curve) -> None:
    worst = 0.0
    for z in curve.distances:
        for angle_deg in curve.angles_deg:
            sigma, fill = sigma_and_fill(PRESETS[curve.preset], z, angle_deg, curve.material)
            published = curve.value(z, float(np.deg2rad(angle_deg)))
            worst = max(worst, abs(residual(curve, fill if curve.quantity == "fill" else sigma, published)))
    # Residuals are stored with four digits; none may have grown.
    assert min(abs(worst - value) for value in STORED) < 2e-3


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
