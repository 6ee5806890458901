"""The environment: a truck before a pallet, to be driven and told when, how far and how high to go in.

Scenes that episodes begin in are sampled when they are first needed, and kept.
"""

from dataclasses import dataclass, field
from functools import partial
from typing import Any, Literal

import gymnasium
import numpy as np
from gymnasium import spaces
from jaxtyping import UInt8

from warehouse_sim.benchmark.docking.closed_loop.drive import COLLIDED, DOCKED
from warehouse_sim.benchmark.docking.closed_loop.episode import Setting, way_is_free
from warehouse_sim.benchmark.docking.closed_loop.starts import Start, sampled_starts
from warehouse_sim.errors import InputError, PlacementError
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.scene import SampledScene, sample_settled_scene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.gym.command import Action, Command
from warehouse_sim.gym.observations import CameraObserver, Observation, Observer, PoseObserver
from warehouse_sim.gym.truck import STAND, Truck

_TRIES = 50
"""Scenes that are tried for one start."""


@dataclass(eq=False)
class Scenes:
    """Some scenes of a recipe.

    Args:
        recipe: Of the scenes.
        seed: Of the scenes.
        first: Index of the first one.
        count: How many there are.
    """

    recipe: Recipe
    seed: int
    first: int
    count: int
    _kept: dict[int, SampledScene] = field(default_factory=dict, init=False)

    @property
    def camera(self) -> PinholeCamera:
        """The truck's."""
        return self.recipe.sensors.make_camera()

    def start(self, rng: np.random.Generator) -> tuple[SampledScene, Start]:
        """Sample a scene, a pallet, the side that it is taken by, and where the truck stands before it.

        Raises:
            PlacementError: A truck has clearance for an approach in none of the scenes that were tried.
        """
        camera = self.camera
        is_free = partial(way_is_free, Setting(self.recipe.name, self.seed, camera))
        for _ in range(_TRIES):
            sampled = self._sampled(self.first + int(rng.integers(self.count)))
            for start in sampled_starts(sampled, camera, is_free, rng):
                return sampled, start
        last = self.first + self.count - 1
        raise PlacementError(
            f"{self.recipe.name}, seed {self.seed}: in scenes {self.first} to {last} no truck has clearance for an "
            "approach; use more scenes or another recipe"
        )

    def _sampled(self, index: int) -> SampledScene:
        if index not in self._kept:
            self._kept[index] = sample_settled_scene(self.recipe, self.seed, index)
        return self._kept[index]


_CONTACT = (COLLIDED, "struck", "pushed", "fell")
"""Outcomes after which something is broken."""
_NEARER = 0.1
"""Reward for a metre nearer to the place where the forks go in."""


class Docking(gymnasium.Env[Observation, Action]):
    """Drive a forklift to a pallet and put the forks into its pockets.

    A step is 0.1 s. An action is what ``Command`` reads from five numbers. ``reset(seed=)`` alone decides the scene,
    the pallet, its side, where the truck stands, its odometry's errors and the camera's noise.

    The reward of a step is 0.1 for a metre nearer to the place 10 cm before the pallet's side (less when farther),
    and at the end 1 where the pallet is docked, -1 where anything was hit, 0 else. ``info["outcome"]`` has the word.

    Args:
        recipe: Where scenes come from: a shipped recipe's name, or a file.
        observes: "poses", the true place of the entry; "images", colour and depth of the camera between the tips, the
            pallet's ground-truth mask and the truck's odometry, a new image each second.
        scenes: How many scenes there are; an episode is in one of them.
        first_scene: Index of the first one: other scenes are for testing.
        scene_seed: Of the scenes.
        render_mode: "rgb_array": ``render`` returns what the camera sees.

    Raises:
        RecipeError: There is no such recipe.
        InputError: An argument is none that there is.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012  as gymnasium has it

    def __init__(
        self,
        recipe: str = "dock_staging",
        observes: Literal["poses", "images"] = "poses",
        scenes: int = 8,
        first_scene: int = 0,
        scene_seed: int = 0,
        render_mode: str | None = None,
    ) -> None:
        if observes not in ("poses", "images") or scenes < 1 or first_scene < 0:
            raise InputError(
                f"Docking: observes 'poses' or 'images' in one scene or more, found {observes!r} and {scenes} scenes "
                f"from {first_scene} on"
            )
        self.render_mode = render_mode
        self.recipe = load_recipe(recipe)
        self._scenes = Scenes(self.recipe, scene_seed, first_scene, scenes)
        self._camera = CameraObserver(self.recipe, self._scenes.camera)
        self._observer: Observer = self._camera if observes == "images" else PoseObserver()
        self.observation_space = self._observer.space
        self.action_space = spaces.Box(-1.0, 1.0, (5,), np.float32)
        self._is_driving = False

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode.

        Args:
            seed: Decides it; None goes on with the stream of the last seed.
            options: None are read.

        Returns:
            The first observation, and what the truck's computer knows: the pallet's type ("obj_id"), the place that it
            was sent to in the frame of odometry ("sent", m), the height of the tines ("tines", m), "K" and
            "T_vehicle_camera".
        """
        super().reset(seed=seed)
        sampled, start = self._scenes.start(self.np_random)
        self._truck = Truck(start, self.np_random)
        self._camera.begin(sampled, start, int(self.np_random.integers(2**31)))
        self._is_driving = True
        return self._observer.observation(self._truck), self._truck.known(self._scenes.camera)

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Drive for 0.1 s, or go in, which ends the episode.

        Raises:
            InputError: The episode has ended or not begun, or the action is not five numbers.
        """
        if not self._is_driving:
            raise InputError("Docking: no episode is going on; call reset() before step()")
        before = self._away()
        outcome = self._truck.obey(Command.of(action))
        self._is_driving = not outcome
        reward = _NEARER * (before - self._away()) + (outcome == DOCKED) - (outcome in _CONTACT)
        info = {"outcome": outcome} if outcome else {}
        return self._observer.observation(self._truck), float(reward), bool(outcome), False, info

    def render(self) -> UInt8[np.ndarray, "h w 3"] | None:
        """Return what the truck's camera sees now."""
        return self._camera.now(self._truck) if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """Release the renderer."""
        self._camera.close()

    @property
    def scene_index(self) -> int:
        """Which of the recipe's scenes the episode is in."""
        return self._truck.start.station.scene.scene_index

    def _away(self) -> float:
        """Return the way (m) from the truck to where the forks go in."""
        aim = self._truck.aim
        return float(np.hypot(aim.along - STAND, aim.aside))
