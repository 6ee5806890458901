"""Scenes that episodes begin in; each is sampled when it is first needed, and kept."""

from dataclasses import dataclass, field
from functools import partial

import numpy as np

from warehouse_sim.benchmark.docking.closed_loop.episode import Setting, way_is_free
from warehouse_sim.benchmark.docking.closed_loop.starts import Start, sampled_starts
from warehouse_sim.errors import PlacementError
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.generation.scene import SampledScene, sample_settled_scene
from warehouse_sim.geometry.camera import PinholeCamera

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
