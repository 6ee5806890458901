"""The second camera of a pair, and the depth that the two give together, rectified where lenses distort."""

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, ClassVar, cast

import cv2
import numpy as np
from jaxtyping import Bool, Float32, UInt8

from warehouse_sim.config import convert, from_mapping, to_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.render.lens import lens_map
from warehouse_sim.schema import CAMERA, RenderBuffers, RgbdReading, StereoReading
from warehouse_sim.sensors.capture import Capture
from warehouse_sim.sensors.rgbd.color import ColorConfig, read_color
from warehouse_sim.sensors.stereo.disparity import (
    SgbmConfig,
    StereoConfig,
    gt_disparity,
    match_sgbm,
    seen_in_both,
)
from warehouse_sim.sensors.view import SensorView


def both_see(
    left: Float32[np.ndarray, "h w"], right: Float32[np.ndarray, "h w"], camera: PinholeCamera
) -> Bool[np.ndarray, "h w"]:
    """Return which pixels of the left image the right camera sees, too; see ``seen_in_both``.

    Args:
        left: f b / z in the left image (px), 0 = nothing there.
        right: f b / z in the right image (px), 0 = nothing there.
        camera: That of both images.
    """
    if camera.distortion is None:
        return seen_in_both(left, right)
    lens, place = lens_map(camera), _places(camera)
    finer = np.float32(lens.source.fx / camera.fx)
    straight = [cv2.remap(image * finer, place, None, cv2.INTER_NEAREST) for image in (left, right)]
    return np.take(seen_in_both(straight[0], straight[1]), lens.nearest)


def match(
    left: UInt8[np.ndarray, "h w 3"], right: UInt8[np.ndarray, "h w 3"], config: SgbmConfig, camera: PinholeCamera
) -> Float32[np.ndarray, "h w"]:
    """Return the disparity (px at the camera's focal length) of the left image by ``match_sgbm``, 0 = none.

    Args:
        left: Left image.
        right: Right image.
        config: The matcher.
        camera: That of both images.
    """
    if camera.distortion is None:
        return match_sgbm(left, right, config)
    lens, place = lens_map(camera), _places(camera)
    straight = [cv2.remap(image, place, None, cv2.INTER_LINEAR) for image in (left, right)]
    found = np.take(match_sgbm(straight[0], straight[1], config), lens.nearest)
    return found * np.float32(camera.fx / lens.source.fx)


@lru_cache(maxsize=2)
def _places(camera: PinholeCamera) -> Float32[np.ndarray, "sh sw 2"]:
    """Return where in the camera's image each pixel of the rectified one looks."""
    return camera.project(lens_map(camera).source.rays()).astype(np.float32)


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
    disparities = [gt_disparity(seen.depth, right_capture.camera.fx, config.baseline) for seen in (left, right)]
    return StereoReading(
        baseline=config.baseline,
        rgb=right_rgb,
        buffers=right,
        disparity=disparities[0],
        in_both=both_see(disparities[0], disparities[1], right_capture.camera),
        matched=None if config.matching is None else match(left_rgb, right_rgb, config.matching, right_capture.camera),
    )
