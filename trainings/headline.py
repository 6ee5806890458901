"""A bundled model's number on two scenes that are drawn on the spot: small enough for a test to measure it again."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from warehouse_sim.estimators.pose.densefusion.estimator import Estimator
from warehouse_sim.estimators.pose.densefusion.objects import read_meshes
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.evaluation.errors.pose_error import add, estimates_in_object
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.render import open_renderer
from warehouse_sim.schema import Observation

RECIPE, SEED, SCENES = "industrial-v1", 1000, 2
LIMIT = 0.10
"""Largest ADD in diameters."""
_LEAST_VISIBLE = 0.1


@dataclass(frozen=True)
class Headline:
    """Fraction of labelled pallets that are at least 10 % visible and whose ADD is below a tenth of the diameter."""

    fraction: float
    """0-1; pallets without an estimate count as failures."""
    count: int
    """Pallets."""

    def __str__(self) -> str:
        return f"ADD < {LIMIT:.0%} of the diameter for {100 * self.fraction:.1f} % of {self.count} pallets"


def observations() -> list[Observation]:
    """Draw and look at the scenes, without LiDAR."""
    return list(observed())


def headline(model: Path, seen: Sequence[Observation]) -> Headline:
    """Estimate the labelled objects of ``seen`` with consensus and without ICP."""
    estimator, meshes = Estimator(model, PredictConfig(selection="consensus", refine="none")), read_meshes(model)
    shapes = {shape.obj_id: shape for shape in estimator.objects}
    good = count = 0
    for observation in seen:
        found = {item.detection: item for item in estimator.estimate(observation)}
        for label in observation.annotations:
            if label.visible_fraction < _LEAST_VISIBLE:
                continue
            count += 1
            if label.instance_id not in found:
                continue
            shape = shapes[label.obj_id]
            symmetry = SymmetryGroup(np.reshape(shape.symmetries, (-1, 4, 4)))
            alike = estimates_in_object(found[label.instance_id].T_camera_object, label.T_camera_object, symmetry)
            good += bool(add(alike, meshes[label.obj_id].vertices).min() < LIMIT * shape.diameter)
    return Headline(good / count, count)


def observed() -> Iterator[Observation]:
    """Yield the observations of the scenes, made one after the other."""
    recipe = load_recipe(RECIPE)
    rig = replace(recipe.sensors, lidar=None)
    with open_renderer("raster") as renderer:
        for index in range(SCENES):
            yield from observe_scene(prepare_scene(recipe, SEED, index).scene, rig, renderer)
