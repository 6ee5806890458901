"""The second camera of a pair and what the two give together."""

import numpy as np
from jaxtyping import UInt8

from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.schema import RenderBuffers, StereoReading
from warehouse_sim.sensors.color import ColorConfig, read_color
from warehouse_sim.sensors.shot import Shot
from warehouse_sim.sensors.stereo.config import StereoConfig
from warehouse_sim.sensors.stereo.disparity import true_disparity
from warehouse_sim.sensors.stereo.rectified import both_see, match


def T_camera_right(config: StereoConfig) -> Transform:
    """Return the pose of the right camera in the frame of the left one."""
    return make_transform(translation=np.array([config.baseline, 0.0, 0.0]))


def read_stereo(
    left: RenderBuffers,
    left_rgb: UInt8[np.ndarray, "h w 3"],
    right: RenderBuffers,
    right_shot: Shot,
    color: ColorConfig,
    config: StereoConfig,
    rng: np.random.Generator,
) -> StereoReading:
    """Return what the right camera reads, and disparities of the left picture.

    Args:
        left: The left camera's clean truth.
        left_rgb: What the left camera read.
        right: The right camera's clean truth.
        right_shot: How the right picture is taken.
        color: Noise of both.
        config: Baseline and matcher.
        rng: Source of the right picture's errors alone.
    """
    right_rgb = read_color(right, right_shot, color, rng)
    disparities = [true_disparity(seen.depth, right_shot.camera.fx, config.baseline) for seen in (left, right)]
    return StereoReading(
        baseline=config.baseline,
        rgb=right_rgb,
        buffers=right,
        disparity=disparities[0],
        in_both=both_see(disparities[0], disparities[1], right_shot.camera),
        matched=None if config.matching is None else match(left_rgb, right_rgb, config.matching, right_shot.camera),
    )
