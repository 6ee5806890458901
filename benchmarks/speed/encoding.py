"""RGB, 16-bit depth and instance masks of real observations as PNG, against OpenCV's encoder."""

from dataclasses import replace
from typing import Any

import cv2
import numpy as np

from benchmarks.speed.cost import Cost, measure, median
from benchmarks.speed.subject import Settings, render_subject
from warehouse_sim.dataset.files.image_io import encode_depth, encode_instance_mask, encode_rgb
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.render import open_renderer
from warehouse_sim.schema import Observation


def encoding(settings: Settings) -> dict[str, Any]:
    """Return the row; images carry the noise of the recipe's sensors, as files do."""
    subject = render_subject(settings)
    rig = replace(subject.recipe.sensors, lidar=None)
    with open_renderer("raster") as renderer:
        observations = list(observe_scene(subject.scene, rig, renderer))
    ours: list[Cost] = []
    theirs: list[Cost] = []
    sizes: list[tuple[int, int]] = []
    for observation in observations * (1 if settings.quick else 3):
        cost, our_files = measure(_ours, observation)
        ours.append(cost)
        cost, their_files = measure(_opencv, observation)
        theirs.append(cost)
        sizes.append((sum(map(len, our_files)), sum(map(len, their_files))))
    our_median, peer_median = median(ours[1:]), median(theirs[1:])  # the first pair warms up
    our_bytes, peer_bytes = np.mean(sizes, axis=0)
    return {
        "what": "a frame to PNG: RGB, 16-bit depth, 16-bit ids, with sensor noise",
        "ours_cpu_s": our_median.cpu_s,
        "peer_cpu_s": peer_median.cpu_s,
        "target": "<= 0.015",
        "ours_wall_s": our_median.wall_s,
        "peer_wall_s": peer_median.wall_s,
        "frames": len(ours) - 1,
        "ours_kb": our_bytes / 1000,
        "peer_kb": peer_bytes / 1000,
        "peer": f"OpenCV {cv2.__version__}",
        "how": "cv2.imencode('.png', image) without parameters, which is its fast run-length strategy",
    }


def _ours(observation: Observation) -> list[bytes]:
    return [
        encode_rgb(observation.rgbd.rgb),
        encode_depth(observation.rgbd.depth, 1000.0, "benchmark"),
        encode_instance_mask(observation.buffers.instance_mask, "benchmark"),
    ]


def _opencv(observation: Observation) -> list[bytes]:
    images = [
        cv2.cvtColor(observation.rgbd.rgb, cv2.COLOR_RGB2BGR),
        np.rint(observation.rgbd.depth * np.float32(1000.0)).astype(np.uint16),
        observation.buffers.instance_mask.astype(np.uint16),
    ]
    return [cv2.imencode(".png", image)[1].tobytes() for image in images]
