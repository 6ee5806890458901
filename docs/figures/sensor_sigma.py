"""The spread of depth on flat targets against the published formulas: docs/images/sensors/depth_sigma.png."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.rgbd.depth import PRESETS, DepthModel
from warehouse_sim.sensors.rgbd.depth.active_stereo import ActiveStereo
from warehouse_sim.sensors.rgbd.depth.structured_light import axial_sigma
from warehouse_sim.sensors.rgbd.depth.time_of_flight import TimeOfFlight
from warehouse_sim.sensors.surfaces import Surfaces
from warehouse_sim.sensors.view import Capture

CAMERA = PinholeCamera.from_focal(640, 240, 500.0)
MIDDLE = np.s_[:, 305:335]
LEANS_DEG = (0, 30, 60)
PANELS = {
    "kinect_v1": (0.9, 3.5, "Nguyen et al. 2012"),
    "d435": (0.4, 5.0, "z^2 0.08 px / (f b)"),
    "d455": (0.6, 5.0, "z^2 0.08 px / (f b)"),
    "flexx2": (0.3, 2.3, "Cai et al. 2024"),
}


def measured(model: DepthModel, z: float, lean_deg: float) -> float:
    """Return the standard deviation of what is read of a white plane (m), NaN where nearly nothing is."""
    lean = np.deg2rad(lean_deg)
    normal = np.array([np.sin(lean), 0.0, -np.cos(lean)])
    along = CAMERA.rays() @ normal
    depth = np.where(along < -1e-3, -z * np.cos(lean) / np.minimum(along, -1e-3), 0.0).astype(np.float32)
    normals = np.broadcast_to(normal.astype(np.float32), (*depth.shape, 3)).copy()
    buffers = RenderBuffers(np.zeros((*depth.shape, 3), np.uint8), depth, np.ones(depth.shape, np.int32), normals)
    white = Surfaces(np.ones_like(depth), np.ones_like(depth), np.zeros_like(depth))
    read = model.read(buffers, Capture(CAMERA, surfaces=white), np.random.default_rng(0))
    found = read[MIDDLE] > 0
    return float((read - depth)[MIDDLE][found].std()) if found.mean() > 0.2 else float("nan")


def published(model: DepthModel, lean_deg: float) -> Callable[[float], float]:
    """Return the model's formula: from z to the standard deviation (m)."""
    theta = np.float32(np.deg2rad(lean_deg))
    if isinstance(model, ActiveStereo):
        return lambda z: z * z * 0.08 / (model.focal_px * model.baseline)
    if isinstance(model, TimeOfFlight):
        return lambda z: float(model.axial_sigma(np.float32(z), theta))
    return lambda z: float(axial_sigma(np.float32(z), theta))


def draw_sigma(path: Path) -> None:
    """Plot a panel a camera: lines are formulas, dots are measured.

    Args:
        path: PNG to write.
    """
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, len(PANELS), figsize=(13, 3.4), constrained_layout=True)
    for axis, (name, (first, last, source)) in zip(axes, PANELS.items(), strict=True):
        model = PRESETS[name]
        leans = LEANS_DEG[:1] if isinstance(model, ActiveStereo) else LEANS_DEG
        for number, lean in enumerate(leans):
            fine, coarse = np.linspace(first, last, 60), np.linspace(first, last, 10)
            formula = published(model, lean)
            axis.plot(fine, [1000 * formula(z) for z in fine], color=f"C{number}", label=f"{lean} deg")
            axis.plot(coarse, [1000 * measured(model, z, lean) for z in coarse], "o", color=f"C{number}", ms=4)
        axis.set(title=f"{name}\n{source}", xlabel="z (m)")
        axis.grid(alpha=0.3)
        axis.legend(fontsize=8)
    axes[0].set_ylabel("standard deviation of depth (mm)")
    figure.savefig(path, dpi=80)
    plt.close(figure)
