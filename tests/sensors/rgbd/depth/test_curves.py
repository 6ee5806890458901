"""Depth presets against published curves of sigma and fill, and that measuring on planes gives what went in."""

import numpy as np
import pytest

from tests.sensors.rgbd.depth.curves import CURVES, Curve
from tests.sensors.rgbd.depth.planes import MATERIALS, sigma_and_fill
from tests.stored import held
from warehouse_sim.sensors.rgbd.depth import PRESETS
from warehouse_sim.sensors.rgbd.depth.model import QuadraticDepth


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
    """The worst residual of each curve is as it is stored: none may have grown."""
    points = []
    for z in curve.distances:
        for angle_deg in curve.angles_deg:
            sigma, fill = sigma_and_fill(PRESETS[curve.preset], z, angle_deg, curve.material)
            found, published = fill if curve.quantity == "fill" else sigma, curve.value(z, float(np.deg2rad(angle_deg)))
            points.append({"z": z, "angle_deg": angle_deg, "published": published, "read": found})
    worst = max(abs(residual(curve, point["read"], point["published"])) for point in points)
    row = {
        "name": f"{curve.preset} {curve.quantity}: {curve.source}",
        "value": worst,
        "unit": "fraction of pixels" if curve.quantity == "fill" else "fraction of the published figure",
        "kind": "the model's own formula" if curve.own else "published",
        "material": curve.material,
        "points": points,
    }
    stored = held("depth_models", __file__, [row])[row["name"]]
    assert worst == pytest.approx(stored["value"], abs=2e-3)


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
