"""A second camera to the right of the first: what it reads, and disparities, true and matched."""

from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Annotated, Any, ClassVar, cast

import cv2
import numpy as np
from jaxtyping import Bool, Float32, UInt8

from warehouse_sim.config import convert, from_mapping, to_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.render.lens import lens_map
from warehouse_sim.schema import CAMERA, RenderBuffers, RgbdReading, StereoReading
from warehouse_sim.sensors.rgbd.color import ColorConfig, read_color
from warehouse_sim.sensors.view import Capture, SensorView

_STEPS = 16.0
"""OpenCV returns disparities in sixteenths of a pixel."""
_BLOCK_PX = 5
"""Edge of the blocks that are compared."""
_UNIQUENESS_PERCENT = 10
"""By how much the best cost must beat the next; higher leaves more holes and fewer errors."""
_SPECKLE_PX = 100
"""Patches smaller than this are removed."""
_LEFT_RIGHT_PX = 1
"""Largest difference between matching from the left and from the right."""
_SAME_PX = 1.0
"""How far apart disparities of one surface may be in the two images (px)."""


@dataclass(frozen=True)
@ranged
class SgbmConfig:
    """Semi-global block matching (Hirschmueller 2008) as OpenCV does it."""

    disparities: Annotated[int, Range(16, 1024, "px")] = 192
    """Largest disparity that is looked for (px), a multiple of 16, 16-1,024; nearer things are not matched."""

    def __post_init__(self) -> None:
        if self.disparities % 16:
            raise ValueError(f"disparities must be a multiple of 16, found {self.disparities}")


@dataclass(frozen=True)
@ranged
class StereoConfig:
    """A camera like the first, parallel to it, on its right; its noise has the first one's settings."""

    baseline: Annotated[float, Range(0.001, 2, "m")] = 0.54
    """Distance of the optical centres (m), 0.001-2; KITTI's is 0.54."""
    matching: SgbmConfig | None = field(default_factory=SgbmConfig)
    """How a disparity is matched from the two noisy images; null = none is."""


def gt_disparity(depth: Float32[np.ndarray, "h w"], focal_px: float, baseline: float) -> Float32[np.ndarray, "h w"]:
    """Return the disparity ``d = f b / z`` (px) of a clean depth image (m), 0 where there is nothing.

    What the left camera sees at column u, the right one has at u - d, unless something hides it there.
    """
    seen = depth > 0
    return np.where(seen, focal_px * baseline / np.where(seen, depth, 1.0), 0.0).astype(np.float32)


def seen_in_both(left: Float32[np.ndarray, "h w"], right: Float32[np.ndarray, "h w"]) -> Bool[np.ndarray, "h w"]:
    """Return which pixels of the left image the right camera sees, too.

    A pixel at column u with disparity d is seen at u - d, if that is in the right image and one of the two columns
    there has the same disparity. This is the check of left against right (Fua 1993) on the ground truth; what fails it
    is hidden by something nearer, or outside.

    Args:
        left: True disparity of the left image (px), 0 = nothing there.
        right: True disparity of the right image (px), 0 = nothing there.
    """
    height, width = left.shape
    there = np.arange(width, dtype=np.float32) - left
    before = np.clip(there, 0, width - 1).astype(np.int32)
    after = np.minimum(before + 1, width - 1)
    row = width * np.arange(height, dtype=np.int32)[:, None]
    # Grazing surfaces change by almost a pixel from column to column, what hides others by more.
    same = np.abs(np.take(right, row + before) - left) <= _SAME_PX
    same |= np.abs(np.take(right, row + after) - left) <= _SAME_PX
    return same & (left > 0) & (there >= 0)


def match_sgbm(
    left: UInt8[np.ndarray, "h w 3"], right: UInt8[np.ndarray, "h w 3"], config: SgbmConfig
) -> Float32[np.ndarray, "h w"]:
    """Return the disparity (px) of the left image that semi-global matching finds, 0 = none.

    The costs of steps of one and of more pixels are 8 and 32 times channels times block area, as OpenCV advises. The
    mode with five directions runs on one thread, so that the same images give the same bytes.
    """
    area = 3 * _BLOCK_PX**2
    matcher = cv2.StereoSGBM.create(
        minDisparity=0,
        numDisparities=config.disparities,
        blockSize=_BLOCK_PX,
        P1=8 * area,
        P2=32 * area,
        disp12MaxDiff=_LEFT_RIGHT_PX,
        uniquenessRatio=_UNIQUENESS_PERCENT,
        speckleWindowSize=_SPECKLE_PX,
        speckleRange=2,
        mode=cv2.STEREO_SGBM_MODE_SGBM,
    )
    # OpenCV gives no value in the first columns, where the largest disparity leaves the image: a margin does it.
    margin = config.disparities
    grey = (cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY) for rgb in (left, right))
    wide = [cv2.copyMakeBorder(one, 0, 0, margin, 0, cv2.BORDER_REPLICATE) for one in grey]
    found = matcher.compute(*wide)[:, margin:].astype(np.float32) / np.float32(_STEPS)
    columns = np.arange(found.shape[1], dtype=np.float32)
    return np.where((found > 0) & (found <= columns), found, np.float32(0.0))


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
        if self.color.auto_white_balance > 0:
            # Both cameras share the gains of the left one, as those of one unit do.
            capture = replace(capture, light=view.light_color(view.T_world_camera))
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
