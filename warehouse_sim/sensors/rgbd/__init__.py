"""RGB-D cameras: a clean rendering becomes the colours and the depth that a real camera would give."""

from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from warehouse_sim.schema import NO_COLOR, RenderBuffers, RgbdReading
from warehouse_sim.sensors.rgbd.color import ColorConfig, read_color
from warehouse_sim.sensors.rgbd.depth import DepthModel, QuadraticDepth, read_depth_model
from warehouse_sim.sensors.view import Capture, SensorView


@dataclass(frozen=True)
class RgbdConfig:
    """The sensor ``rgbd``: a depth camera and a colour camera that share their pixels.

    Image size, focal length and lens are those of the rig's camera.
    """

    is_camera: ClassVar[bool] = True

    depth: DepthModel = field(default_factory=QuadraticDepth, metadata={"from_plain": read_depth_model})
    """A preset's name (kinect_v1, d435, d455, flexx2, azure_kinect, tof_industrial), or model and settings."""
    color: ColorConfig = field(default_factory=ColorConfig)
    """Exposure, noise and lens; ``ideal`` = none."""

    def read(self, view: SensorView, rng: np.random.Generator) -> RgbdReading:
        """Return what the camera reads from where it is."""
        depth, T_world_camera = self.depth, view.T_world_sensor
        buffers = view.render(T_world_camera, normals=depth.needs_normals)
        surfaces = view.surfaces(T_world_camera, depth.needs_reflections) if depth.needs_surfaces else None
        film = view.film_before(T_world_camera) if depth.sees_film else None
        capture = Capture(view.camera, view.exposure_ev, view.camera_motion(T_world_camera), surfaces, film)
        if view.color and self.color.auto_white_balance > 0:
            capture = replace(capture, light=view.light_color(T_world_camera))
        return read_rgbd(buffers, capture, self, rng, view.color)


def read_rgbd(
    buffers: RenderBuffers, capture: Capture, config: RgbdConfig, rng: np.random.Generator, color: bool = True
) -> RgbdReading:
    """Return what a camera reads of a clean rendering.

    Depth and colour have random streams of their own, both made from ``rng``: settings of one never change the other.

    Args:
        buffers: The clean ground truth.
        capture: How the image is taken.
        config: The camera's noise.
        rng: Source of all errors.
        color: Whether the image is wanted; without it depth is the same.
    """
    depth_rng, color_rng = rng.spawn(2)
    return RgbdReading(
        rgb=read_color(buffers, capture, config.color, color_rng) if color else NO_COLOR,
        depth=config.depth.read(buffers, capture, depth_rng),
    )


__all__ = ["RgbdConfig", "read_rgbd"]
