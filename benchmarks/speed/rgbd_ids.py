"""RGB, depth and instance masks with shadows against another renderer: same scene and camera."""

from typing import Any

import numpy as np

from benchmarks.speed.cost import median
from benchmarks.speed.render_process import RenderProcess, render_in_turns
from benchmarks.speed.subject import Settings, Subject, render_subject
from warehouse_sim.schema import RenderBuffers

HOW = {
    "mujoco": "mjr_render with shadows and 4 samples (the default) for the colours, then once more in segmentation "
    "mode for both ids and depth, where mujoco.Renderer would draw a third time. One mesh asset for each model and "
    "material, one geom for each instance and material; compiled, and mjv_updateScene called, once a scene",
    "pyrender": "OffscreenRenderer.render with SHADOWS_SPOT and 4 samples (the default) for the colours, then once "
    "more with SEG for ids and depth",
}
"""How each peer is used, which is how the backend of its name uses it."""
TARGETS = {"mujoco": 8.0, "pyrender": 15.0}


def compare(peer: str, settings: Settings) -> dict[str, Any]:
    """Return the row of one peer."""
    subject = render_subject(settings)
    with (
        RenderProcess("raster", subject.scene, subject.camera) as ours,
        RenderProcess(peer, subject.scene, subject.camera) as theirs,
    ):
        ours_costs, peer_costs = render_in_turns([ours, theirs], subject.views[::2], repeats=1)
        same = _agreement(subject, ours, theirs)
        names: dict[str, Any] = {"ours": ours.description, "peer": theirs.description}
        most, lights = theirs.capabilities.max_lights, len(subject.scene.lights)
        names["peer_lights"] = lights if most is None else min(most, lights)
        loads = {"ours_load_cpu_s": ours.load_cost.cpu_s, "peer_load_cpu_s": theirs.load_cost.cpu_s}
    our_median, peer_median = median(ours_costs), median(peer_costs)
    ratios = [theirs.cpu_s / ours.cpu_s for ours, theirs in zip(ours_costs, peer_costs, strict=True)]
    return {
        "what": "a frame: RGB + depth + ids, shadows on",
        "ours_cpu_s": our_median.cpu_s,
        "peer_cpu_s": peer_median.cpu_s,
        "target": f"ratio >= {TARGETS[peer]:g}",
        "ratio_by_frame": [min(ratios), max(ratios)],
        "ours_wall_s": our_median.wall_s,
        "peer_wall_s": peer_median.wall_s,
        "frames": len(ours_costs),
        **loads,
        **names,
        **same,
        "how": HOW[peer],
        "scene": subject.facts(),
    }


def _agreement(subject: Subject, ours: RenderProcess, theirs: RenderProcess) -> dict[str, float]:
    """Return the lowest fractions of pixels at which ids and depths of both agree, over two views.

    Amodal masks' pixels may differ; anything beyond says that the two did not draw the same scene.
    """
    fractions = [_fractions(ours.look(view), theirs.look(view)) for view in subject.views[:2]]
    ids, depth = (min(values) for values in zip(*fractions, strict=True))
    return {"ids_agree": ids, "depth_agrees": depth}


def _fractions(ours: RenderBuffers, theirs: RenderBuffers) -> tuple[float, float]:
    near = np.abs(ours.depth - theirs.depth) <= 0.005 + 0.005 * ours.depth
    return float(np.mean(ours.instance_mask == theirs.instance_mask)), float(np.mean(near))
