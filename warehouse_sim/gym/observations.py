"""What an agent is shown: the true place of the entry, or what the truck's camera reads."""

from typing import Any, Protocol

import numpy as np
from gymnasium import spaces
from jaxtyping import UInt8

from warehouse_sim.benchmark.docking.closed_loop.perceive import LiveScene, Shot
from warehouse_sim.benchmark.docking.closed_loop.settings import BASE, DRIVE
from warehouse_sim.benchmark.docking.closed_loop.starts import Start
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.generation.scene import SampledScene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.gym.truck import Truck
from warehouse_sim.render import open_renderer
from warehouse_sim.render.renderer import Renderer
from warehouse_sim.scene.viewpoints.mountings import FORKLIFT

Observation = Any
"""An array of poses, or a mapping with images."""
_FAR, _LONG = 100.0, 1000.0
"""Bounds of places (m) and of time (s)."""


class Observer(Protocol):
    """Makes observations."""

    @property
    def space(self) -> spaces.Space[Any]:
        """Of the observations."""

    def observation(self, truck: Truck) -> Observation:
        """Return what is seen now."""


class PoseObserver:
    """Shows eight numbers: the entry as it is, and how the truck moves.

    From the tips to the face along the entry's axis (m), the truck's offset to the left of that axis (m), sine and
    cosine of its heading against it, how much higher than the tines the entry is (m), speed (m/s), angle of the wheel
    (rad), time (s).
    """

    def __init__(self) -> None:
        high = np.array([_FAR, _FAR, 1.0, 1.0, _FAR, 10.0, np.pi, _LONG], dtype=np.float32)
        self.space: spaces.Space[Any] = spaces.Box(-high, high, dtype=np.float32)

    def observation(self, truck: Truck) -> Observation:
        """Return the numbers."""
        aim, motion = truck.aim, truck.motion
        up = float(truck.T_world_dock[2, 3]) - truck.tines
        turned = [np.sin(aim.turned), np.cos(aim.turned)]
        values = [aim.along - FORKLIFT.tip, aim.aside, *turned, up, motion.speed, motion.steering, truck.time]
        return np.array(values, dtype=np.float32)


class CameraObserver:
    """Shows a new image each second, and where odometry takes the truck for.

    ``rgb``, ``depth`` (m, 0 = no reading) and ``mask`` (1 = the pallet, by ground truth) are those of the last image.
    ``truck`` is x and y (m), sine and cosine of the heading in the frame of odometry, which begins where the truck
    does, speed (m/s), angle of the wheel (rad), time (s), and the age of the image (s).

    Args:
        recipe: Its rig is the truck's.
        camera: Of the rig.
    """

    def __init__(self, recipe: Recipe, camera: PinholeCamera) -> None:
        self._recipe, shape = recipe, (camera.height, camera.width)
        high = np.array([_FAR, _FAR, 1.0, 1.0, 10.0, np.pi, _LONG, _LONG], dtype=np.float32)
        self.space: spaces.Space[Any] = spaces.Dict(
            {
                "rgb": spaces.Box(0, 255, (*shape, 3), np.uint8),
                "depth": spaces.Box(0.0, np.float32(1e4), shape, np.float32),
                "mask": spaces.Box(0, 1, shape, np.uint8),
                "truck": spaces.Box(-high, high, dtype=np.float32),
            }
        )
        self._renderer: Renderer | None = None
        self._live: LiveScene | None = None
        self._loaded: SampledScene | None = None

    def begin(self, sampled: SampledScene, start: Start, episode: int) -> None:
        """Begin an episode.

        Args:
            sampled: Its scene.
            start: Its start.
            episode: Number of its noise.
        """
        self._sampled, self._start, self._episode = sampled, start, episode
        self._images = 0

    def observation(self, truck: Truck) -> Observation:
        """Return the last image, taken now where one is due, and the odometry."""
        if truck.time >= self._images * DRIVE.period - 1e-9:
            self._shot, self._taken = self._shoot(truck, str(self._images)), truck.time
            self._images += 1
        shot, at, motion = self._shot, truck.odometry.pose, truck.motion
        age = truck.time - self._taken
        values = [at.x, at.y, np.sin(at.yaw), np.cos(at.yaw), motion.speed, motion.steering, truck.time, age]
        return {
            "rgb": shot.rgb.copy(),
            "depth": shot.depth.copy(),
            "mask": (shot.instance_mask == self._start.pallet.instance_id).astype(np.uint8),
            "truck": np.array(values, dtype=np.float32),
        }

    def now(self, truck: Truck) -> UInt8[np.ndarray, "h w 3"]:
        """Return the colours that the camera reads now, beside the images of the episode."""
        return self._shoot(truck, "render").rgb

    def close(self) -> None:
        """Release the renderer."""
        if self._renderer is not None:
            self._renderer.close()
        self._renderer = self._live = self._loaded = None

    def _shoot(self, truck: Truck, image: str) -> Shot:
        stream = f"docking task {self._episode} {image}"
        return self._scene().shoot(truck.viewpoint(), truck.driven, stream)

    def _scene(self) -> LiveScene:
        """Return the scene in light, loaded; that of the last image where it serves."""
        if self._live is None or self._loaded is not self._sampled:
            self._renderer = self._renderer or open_renderer("raster")
            self._live = LiveScene(self._recipe, self._sampled, self._renderer, BASE.light, BASE.sensor)
            self._loaded = self._sampled
        return self._live
