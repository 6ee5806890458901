"""Do depth models read what was published of the cameras? Sigma and fill by range, angle and material.

    python -m benchmarks.acceptance.depth_models                    # prints; about a minute
    python -m benchmarks.acceptance.depth_models --presets d455     # of one
    python -m benchmarks.acceptance.depth_models --write            # and stores results/depth_models.json

Two kinds of rows: one for each published curve, with the residuals at all of its places, and one for each preset with
what it reads of four materials at 0-75 degrees, where there is mostly no source to compare with.
"""

from typing import Any

import numpy as np
import tyro

from benchmarks.acceptance.depth_curves import CURVES, Curve
from benchmarks.acceptance.depth_planes import MATERIALS, sigma_and_fill
from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim.sensors.rgbd.depth import PRESETS

ANGLES_DEG = (0.0, 15.0, 30.0, 45.0, 60.0, 70.0, 75.0)
FRACTIONS_OF_RANGE = (0.1, 0.2, 0.4, 0.6, 0.8)
"""Distances of the table, between the ends of a preset's range."""


def main(presets: tuple[str, ...] = (), write: bool = False) -> None:
    """Measure.

    Args:
        presets: Which; by default all.
        write: Store the result.
    """
    names = list(presets) or list(PRESETS)
    rows = [_compared(curve) for curve in CURVES if curve.preset in names]
    rows += [_table(name) for name in names]
    for row in rows:
        print(f"{row['name']:<110} {row['value']:.3g}")
    if write:
        write_result(
            RESULTS / "depth_models.json", "python -m benchmarks.acceptance.depth_models --write", rounded(rows),
            materials={name: list(values) for name, values in MATERIALS.items()},
        )  # fmt: skip


def _compared(curve: Curve) -> dict[str, Any]:
    """Return a published curve, what is read at its places, and how far that is off: ``value`` is the worst."""
    points = []
    for z in curve.distances:
        for angle_deg in curve.angles_deg:
            sigma, fill = sigma_and_fill(PRESETS[curve.preset], z, angle_deg, curve.material)
            read = fill if curve.quantity == "fill" else sigma
            published = curve.value(z, float(np.deg2rad(angle_deg)))
            points.append({"z": z, "angle_deg": angle_deg, "published": published, "read": read}
                          | {"residual": _residual(curve, read, published)})  # fmt: skip
    return {
        "name": f"{curve.preset} {curve.quantity}: {curve.source}",
        "value": max(abs(point["residual"]) for point in points),
        "kind": "the model's own formula" if curve.own else "published",
        "unit": "fraction of pixels" if curve.quantity == "fill" else "fraction of the published figure",
        "material": curve.material,
        "points": points,
    }


def _residual(curve: Curve, read: float | None, published: float) -> float:
    """Return read less published, as a fraction where it is a length; of a bound only what exceeds it."""
    if read is None:
        return 1.0
    if curve.quantity == "fill":
        return read - published
    off = read / published - 1.0
    return max(off, 0.0) if curve.quantity == "bound" else off


def _table(name: str) -> dict[str, Any]:
    """Return what a preset reads of all materials; ``value`` is the mean fill."""
    model = PRESETS[name]
    distances = [model.min_range + fraction * (model.max_range - model.min_range) for fraction in FRACTIONS_OF_RANGE]
    cells = []
    for material in MATERIALS:
        for z in distances:
            for angle_deg in ANGLES_DEG:
                sigma, fill = sigma_and_fill(model, z, angle_deg, material)
                cells.append([material, z, angle_deg, sigma, fill])
    return {
        "name": f"{name}: four materials, 0-75 deg",
        "value": float(np.mean([cell[-1] for cell in cells])),
        "unit": "mean fraction of pixels read; no source but the curves above",
        "columns": ["material", "z_m", "angle_deg", "sigma_m", "fill"],
        "cells": cells,
    }


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
