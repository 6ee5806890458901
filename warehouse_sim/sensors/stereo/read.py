"""The second camera of a pair and what the two give together."""

from dataclasses import dataclass, field
from typing import Any, ClassVar, cast

import numpy as np
from jaxtyping import UInt8

from warehouse_sim.config import convert, from_mapping, to_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.schema import CAMERA, RenderBuffers, RgbdReading, StereoReading
from warehouse_sim.sensors.capture import Capture
from warehouse_sim.sensors.rgbd.color import ColorConfig, read_color
from warehouse_sim.sensors.stereo.config import StereoConfig
from warehouse_sim.sensors.stereo.disparity import true_disparity
from warehouse_sim.sensors.stereo.rectified import both_see, match
from warehouse_sim.sensors.view import SensorView


@dataclass(frozen=True)
class StereoCamera:
    """The sensor ``stereo``: a camera to the right of the rig's, like it and parallel to it."""

    is_camera: ClassVar[bool] = True

    config: StereoConfig = field(default_factory=StereoConfig)
    """Baseline and matcher."""
    color: ColorConfig = field(default_factory=ColorConfig)
    """Exposure, noise and lens of its image."""

    @classmethod
    def from_plain(cls, data: Any, where: str) -> "StereoCamera":
        """Read settings of the pair, and of colour under ``color``.

        Raises:
            ConfigError: Unknown setting.
        """
        if not isinstance(data, dict) or "color" not in data:
            return cls(from_mapping(StereoConfig, data, where))
        own = {key: value for key, value in data.items() if key != "color"}
        return cls(from_mapping(StereoConfig, own, where), convert(ColorConfig, data["color"], f"{where}: color"))

    def to_plain(self) -> dict[str, Any]:
        """Return what ``from_plain`` reads back."""
        return {**to_mapping(self.config), "color": to_mapping(self.color)}

    def read(self, view: SensorView, rng: np.random.Generator) -> StereoReading:
        """Return what the right camera reads, and disparities of the rig's camera.

        Raises:
            ConfigError: It does not sit its baseline to the right of the rig's camera.
        """
        T_left_right = T_camera_right(self.config)
        if not np.allclose(view.T_camera_sensor, T_left_right, atol=1e-9):
            baseline = self.config.baseline
            raise ConfigError(
                f"sensors: a stereo camera of baseline {baseline:g} m sits that far to the right of the rig's camera, "
                f"parallel to it; mount it with left: {-baseline:g} and nothing else"
            )
        left = view.render()
        T_world_right = view.T_world_camera @ T_left_right
        right = view.render(T_world_right)
        capture = Capture(view.camera, view.exposure_ev, view.camera_motion(T_world_right))
        left_rgb = cast(RgbdReading, view.readings[CAMERA]).rgb
        return read_stereo(left, left_rgb, right, capture, self.color, self.config, rng)


def T_camera_right(config: StereoConfig) -> Transform:
    """Return the pose of the right camera in the frame of the left one."""
    return make_transform(translation=np.array([config.baseline, 0.0, 0.0]))


def read_stereo(
    left: RenderBuffers,
    left_rgb: UInt8[np.ndarray, "h w 3"],
    right: RenderBuffers,
    right_capture: Capture,
    color: ColorConfig,
    config: StereoConfig,
    rng: np.random.Generator,
) -> StereoReading:
    """Return what the right camera reads, and disparities of the left image.

    Args:
        left: The left camera's clean ground truth.
        left_rgb: What the left camera read.
        right: The right camera's clean ground truth.
        right_capture: How the right image is taken.
        color: Noise of both.
        config: Baseline and matcher.
        rng: Source of the right image's errors alone.
    """
    right_rgb = read_color(right, right_capture, color, rng)
    disparities = [true_disparity(seen.depth, right_capture.camera.fx, config.baseline) for seen in (left, right)]
    return StereoReading(
        baseline=config.baseline,
        rgb=right_rgb,
        buffers=right,
        disparity=disparities[0],
        in_both=both_see(disparities[0], disparities[1], right_capture.camera),
        matched=None if config.matching is None else match(left_rgb, right_rgb, config.matching, right_capture.camera),
    )
