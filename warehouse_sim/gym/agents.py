"""Agents to compare with: one that knows nothing, one that is shown poses, and one that estimates them."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from warehouse_sim.benchmark.docking.closed_loop.belief import Aim, Believed
from warehouse_sim.benchmark.docking.closed_loop.perceive import nominal
from warehouse_sim.benchmark.docking.closed_loop.settings import DRIFTS, DRIVE
from warehouse_sim.benchmark.docking.closed_loop.vehicle import pursue, slow_down, wheel_for
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.gravity import down_of_camera
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.tracking.tracker import View
from warehouse_sim.evaluation.docking.fork import HEEL_GAP, docking_faces
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.gym.command import Action, Command
from warehouse_sim.gym.observations import Observation
from warehouse_sim.gym.truck import STAND
from warehouse_sim.scene.viewpoints.mountings import FORKLIFT, pose_on_floor

_THERE, _CREEP = 2e-3, 0.01
"""So near (m) the truck has arrived, and it never drives slower (m/s) before."""
_LEAST_PIXELS = 32
"""Of a mask that is estimated, as in the closed loop."""


class Agent(Protocol):
    """Whoever drives."""

    observes: str
    """What it is shown, as ``Docking`` takes it."""

    def begin(self, known: Mapping[str, Any]) -> None:
        """Take over what ``reset`` says."""

    def act(self, observation: Observation) -> Action:
        """Return what the truck is to do."""


@dataclass
class RandomAgent:
    """Acts at random, by ``rng``."""

    rng: np.random.Generator
    observes = "poses"

    def begin(self, known: Mapping[str, Any]) -> None:
        """Do nothing."""

    def act(self, observation: Observation) -> Action:
        """Return any action."""
        return self.rng.uniform(-1.0, 1.0, 5).astype(np.float32)


class PursuitAgent:
    """Follows the true entry's axis by the law of the closed loop."""

    observes = "poses"

    def begin(self, known: Mapping[str, Any]) -> None:
        """Do nothing: poses say all."""

    def act(self, observation: Observation) -> Action:
        """Return the order of the law."""
        gap, aside, sine, cosine, up, _, steering, _ = observation.tolist()
        return towards(Aim(gap + FORKLIFT.tip, aside, float(np.arctan2(sine, cosine))), up, steering)


@dataclass
class EstimatingAgent:
    """Estimates the pallet in each image, filters, and follows the axis of the entry that it believes in.

    Args:
        estimator: Shown the objects of the recipe.
        objects: Those of the recipe, by obj_id.
    """

    estimator: PoseEstimator
    objects: Mapping[int, ObjectInfo]
    observes = "images"
    _T_odom_dock: Transform | None = field(default=None, init=False)

    def begin(self, known: Mapping[str, Any]) -> None:
        """Forget the last pallet."""
        self._known = known
        self._object = self.objects[known["obj_id"]]
        faces = docking_faces(self._object.size, self._object.pockets)
        self._believed = Believed(self._object.symmetry, faces, DRIFTS["usual"])
        self._T_odom_dock = None

    def act(self, observation: Observation) -> Action:
        """Return the order of the law for what is believed; stand still before the first estimate."""
        x, y, sine, cosine, _, steering, time, age = observation["truck"].tolist()
        T_odom_vehicle = pose_on_floor(x, y, float(np.arctan2(sine, cosine)))
        if age == 0.0:
            self._see(observation, T_odom_vehicle, time)
        if self._T_odom_dock is None:
            return Command().action
        up = float(self._T_odom_dock[2, 3]) - self._known["tines"]
        return towards(Aim.of(self._T_odom_dock, T_odom_vehicle), up, steering)

    def _see(self, observation: Observation, T_odom_vehicle: Transform, time: float) -> None:
        mask, depth, K = observation["mask"] > 0, observation["depth"], self._known["K"]
        if int(mask.sum()) < _LEAST_PIXELS:
            return
        camera = PinholeCamera(depth.shape[1], depth.shape[0], K[0, 0], K[1, 1], K[0, 2], K[1, 2])
        T_odom_camera = T_odom_vehicle @ self._known["T_vehicle_camera"]
        number = round(time / DRIVE.period)
        seen = (Detection(mask, self._object.obj_id, number=1),)
        down = down_of_camera(T_odom_camera)
        image = RgbdImage(camera, depth, seen, observation["rgb"], 0, number, T_odom_camera, down)
        found = [item for item in self.estimator.estimate(image) if not item.rejected]
        if not found:
            return
        best = max(found, key=lambda item: item.score)
        if best.covariance is None:
            best = replace(best, covariance=nominal(0.02, 1.5))
        self._believed.take(View(0, number, camera, T_odom_camera, time), best)
        self._T_odom_dock = self._believed.entry(T_odom_camera)


def towards(aim: Aim, up: float, steering: float) -> Action:
    """Return what brings the truck onto the axis of an entry, and in once it stands before it.

    Args:
        aim: Where the entry is from the truck.
        up: How much higher than the tines it is (m).
        steering: Angle of the wheel (rad).
    """
    left = aim.along - STAND
    if left <= _THERE:
        way = aim.along / np.cos(aim.turned) - FORKLIFT.front - HEEL_GAP
        return Command(goes_in=True, way=float(way), up=up).action
    curvature = pursue(left, aim.aside, aim.turned)
    speed = max(slow_down(left), _CREEP)
    if abs(wheel_for(curvature) - steering) > DRIVE.wheel_off:
        speed = min(speed, DRIVE.slow)
    return Command(speed, curvature).action
