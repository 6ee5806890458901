"""The fast model beside the reference: fill, sigma and edges of one case."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Float32

from tests.sensors.rgbd.depth.dots.cases import RIGS, Case, middle
from tests.sensors.rgbd.depth.dots.infrared import ambient_light, boards_seen, gt_depth, infrared_pair
from tests.sensors.rgbd.depth.dots.matcher import Matcher, match
from tests.sensors.targets import with_constants
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render.display import to_display
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.rgbd.depth import PRESETS
from warehouse_sim.sensors.rgbd.depth.active_stereo import ActiveStereo
from warehouse_sim.sensors.surfaces import Surfaces
from warehouse_sim.sensors.view import Capture

Depth = Float32[np.ndarray, "h w"]
SEEDS = (0, 1)
WRONG_PX = 1.0
"""Disparities that are wrong by more are no readings of the surface, and left out of sigma."""


def by_reference(case: Case, seed: int) -> Depth:
    """Return the disparity that the matcher finds (px), 0 = none."""
    left, right = infrared_pair(case.place, RIGS[case.preset], np.random.default_rng(seed))
    return match(left, right, Matcher())


def by_model(case: Case, seed: int) -> Depth:
    """Return the disparity that the fast model reads, 0 = none: without a unit's errors, from the imager's place."""
    rig, place = RIGS[case.preset], case.place
    camera = PinholeCamera.from_focal(*rig.size_wh, rig.focal_px)
    depth, board = gt_depth(place, rig), boards_seen(place, rig)
    normals = np.stack([item.normal for item in place.boards])[board].astype(np.float32)
    lux = max(place.ambient_lux, 1.0)
    ev = float(np.log2(lux / np.pi / 0.5 / 1.2))  # white is half of what the image can hold
    linear = (ambient_light(place, rig) / lux * 0.5).astype(np.float32)
    rgb = to_display(np.repeat(linear[..., None], 3, axis=-1))
    images = (
        np.array([getattr(item, name) for item in place.boards], np.float32)[board]
        for name in ("remission", "roughness", "metallic")
    )
    model = PRESETS[case.preset]
    assert isinstance(model, ActiveStereo)
    model = replace(model, min_range=0.05, max_range=100.0, color_offset=0.0)
    model = with_constants(model, unit_scale=0.0, unit_bow_px=0.0, unit_registration_px=0.0)
    buffers = RenderBuffers(rgb, depth, board.astype(np.int32) + 1, normals)
    read = model.read(buffers, Capture(camera, ev, surfaces=Surfaces(*images)), np.random.default_rng(seed))
    return np.divide(rig.focal_px * rig.baseline, read, out=np.zeros_like(read), where=read > 0)


def wall_figures(case: Case, found: list[Depth]) -> dict[str, float | None]:
    """Return the fraction that is read, and the sigma of its disparity (px; None where too little is)."""
    rig, part = RIGS[case.preset], middle(case)
    unit = rig.focal_px * rig.baseline
    true = unit / gt_depth(case.place, rig)[part]
    errors, fills = [], []
    for disparity in found:
        read = disparity[part]
        right = (read > 0) & (np.abs(read - true) < WRONG_PX)
        fills.append((read > 0).mean())
        errors.append((read - true)[right])
    error = np.concatenate([item - item.mean() if item.size else item for item in errors])
    sigma_px = float(error.std()) if error.size > 200 else None
    return {"fill": float(np.mean(fills)), "sigma_px": sigma_px}


def edge_figures(case: Case, found: list[Depth]) -> dict[str, float]:
    """Return widths a row (px): holes left and right of the near board, and by how much it seems wider."""
    rig = RIGS[case.preset]
    unit, board = rig.focal_px * rig.baseline, boards_seen(case.place, rig)
    row = board[rig.size_wh[1] // 2]
    first, last = int(np.flatnonzero(row == 0)[0]), int(np.flatnonzero(row == 0)[-1])
    between = unit * (0.5 / case.place.boards[0].z + 0.5 / case.place.boards[1].z)
    sums: dict[str, list[float]] = {"holes_left": [], "holes_right": [], "wider_left": [], "wider_right": []}
    reach = int(unit * (1 / case.place.boards[0].z - 1 / case.place.boards[1].z)) + 16
    for disparity in found:
        inner = disparity[10:-10]
        left, right = inner[:, max(first - reach, 0) : first + 4], inner[:, last - 3 : last + 17]
        sums["holes_left"].append(float((left == 0).sum(axis=1).mean()))
        sums["holes_right"].append(float((right == 0).sum(axis=1).mean()))
        sums["wider_left"].append(float((left[:, :-4] > between).sum(axis=1).mean()))
        sums["wider_right"].append(float((right[:, 4:] > between).sum(axis=1).mean()))
    return {name: float(np.mean(values)) for name, values in sums.items()}


def compared(case: Case) -> dict[str, Any]:
    """Return both figures of a case."""
    figures: Callable[[Case, list[Depth]], Any] = edge_figures if case.edge else wall_figures
    reference = figures(case, [by_reference(case, seed) for seed in SEEDS])
    fast = figures(case, [by_model(case, seed) for seed in SEEDS])
    return {"name": f"{case.preset}: {case.name}", "reference": reference, "fast": fast}
