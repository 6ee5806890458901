"""What each model of a depth or colour camera costs on one frame, without drawing it."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.speed.cost import Cost, measure, median
from benchmarks.speed.subject import Settings, render_subject
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.processes import keep_freed_memory
from warehouse_sim.render import open_renderer
from warehouse_sim.render.lens import LensRenderer
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.motion import Motion
from warehouse_sim.sensors.rgbd import RgbdConfig, read_rgbd
from warehouse_sim.sensors.rgbd.color import COLOR_PRESETS, ColorConfig, read_color
from warehouse_sim.sensors.rgbd.depth import MODELS, PRESETS
from warehouse_sim.sensors.rig.camera import CAMERA_PRESETS
from warehouse_sim.sensors.stereo import SgbmConfig, StereoConfig, T_camera_right, match_sgbm, read_stereo
from warehouse_sim.sensors.surfaces import see_surfaces
from warehouse_sim.sensors.view import Capture

MOTION = Motion(np.array([0.0, 0.0, 2.0]), np.array([0.0, 0.3, 0.0]))
"""2 m/s ahead, turning by 17 degrees a second."""
LITTLE_LIGHT = 6.0
"""Exposure value at which the longest time is used."""


def rgbd_models(settings: Settings) -> dict[str, Any]:
    """Return the row: the default camera, and a table of all models."""
    keep_freed_memory()  # as workers do
    subject = render_subject(settings)
    camera, caster = subject.camera, RayCaster(subject.scene)
    repeats = 1 if settings.quick else 9
    with open_renderer("raster") as renderer:
        renderer.load(subject.scene)
        buffers = renderer.render(camera, subject.views[0], normals=True)
        there = subject.views[0] @ T_camera_right(StereoConfig())
        right = renderer.render(camera, there)
        sampled = _cost(repeats, renderer.render, camera, there)
        lens = LensRenderer(renderer)
        lens.load(subject.scene)
        through_lens = _cost(repeats, lens.render, CAMERA_PRESETS["kitti_raw"].make(), subject.views[0], True)
    view, rng = subject.views[0], np.random.default_rng(0)
    capture = Capture(camera, LITTLE_LIGHT, surfaces=see_surfaces(subject.scene, caster, camera, view))
    moving = replace(capture, motion=MOTION)
    cases: dict[str, tuple[Any, ...]] = {
        "materials of the pixels": (see_surfaces, subject.scene, caster, camera, view),
        **{f"depth: {kind}": (model().read, buffers, capture, rng) for kind, model in MODELS.items()},
        "colour": (read_color, buffers, capture, ColorConfig(), rng),
        "colour, moving": (read_color, buffers, moving, ColorConfig(), rng),
        "colour, raw": (read_color, buffers, capture, COLOR_PRESETS["raw"], rng),
        "colour, plain": (read_color, buffers, capture, COLOR_PRESETS["plain"], rng),
    }
    costs = {name: _cost(repeats, *call) for name, call in cases.items()}
    costs["right picture: drawn"] = sampled
    costs["picture through a lens (kitti_raw): drawn and resampled"] = through_lens
    costs |= _stereo(repeats, camera, buffers, right, rng)
    whole = _cost(repeats, read_rgbd, buffers, capture, RgbdConfig(), rng)
    costs["colour and depth: d455"] = _cost(repeats, read_rgbd, buffers, capture, RgbdConfig(PRESETS["d455"]), rng)
    return {
        "what": "the errors of the default RGB-D camera on a frame",
        "ours_cpu_s": whole.cpu_s,
        "ours_wall_s": whole.wall_s,
        "target": "<= 0.025",
        "models_cpu_s": {name: cost.cpu_s for name, cost in costs.items()},
        "size_wh": [camera.width, camera.height],
    }


def _stereo(
    repeats: int, camera: PinholeCamera, left: RenderBuffers, right: RenderBuffers, rng: np.random.Generator
) -> dict[str, Cost]:
    """Return what the second camera adds to a frame, once its image is drawn."""
    config, capture = StereoConfig(matching=None), Capture(camera, LITTLE_LIGHT)
    rgb = [read_color(seen, capture, ColorConfig(), rng) for seen in (left, right)]
    return {
        "right picture: read, true disparity": _cost(
            repeats, read_stereo, left, rgb[0], right, capture, ColorConfig(), config, rng
        ),
        "disparity: semi-global matching": _cost(repeats, match_sgbm, *rgb, SgbmConfig()),
    }


def _cost(repeats: int, work: Callable[..., Any], *arguments: Any) -> Cost:
    return median([measure(work, *arguments)[0] for _ in range(repeats + 1)][1:])
