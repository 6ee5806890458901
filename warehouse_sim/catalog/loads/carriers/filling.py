"""Goods that lie in a carrier and are sampled with it: they cannot leave it, so that physics need not know them."""

from dataclasses import replace

import numpy as np

from warehouse_sim.catalog.loads.cartons import carton
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.schema import ObjectModel, Part

_ARTICLES = ("carton_400x300x300", "carton_400x300x200", "carton_300x200x200")


def stacked_cartons(
    size: tuple[float, float, float], floor: float, seed: int, articles: tuple[str, ...] = _ARTICLES
) -> tuple[list[Part], float]:
    """Return cartons that fill a space to most of its height, with their mass (kg).

    Args:
        size: Edges of the space (m), centred on the z axis.
        floor: Height of its floor (m).
        seed: Of what lies where.
        articles: Cartons to take, one a layer.
    """
    rng = np.random.default_rng(seed)
    parts: list[Part] = []
    level, mass = 0.0, 0.0
    while True:
        model = carton(str(rng.choice(articles)))
        if level + model.size[2] > size[2]:
            return parts, mass
        ways = [[int(size[axis] / edges[axis]) for axis in (0, 1)] for edges in (model.size[:2], model.size[1::-1])]
        turned = int(np.prod(ways[1])) > int(np.prod(ways[0]))
        counts, edges = ways[turned], model.size[1::-1] if turned else model.size[:2]
        last = level + 2 * model.size[2] > size[2]
        for i in range(counts[0]):
            for j in range(counts[1]):
                if last and rng.random() < 0.35:
                    continue
                cell = np.array([size[0] / counts[0], size[1] / counts[1]])
                place = (np.array([i, j]) + 0.5) * cell - np.array(size[:2]) / 2
                place = place + rng.uniform(-0.8, 0.8, 2) * np.minimum((cell - edges) / 2, 0.012)
                yaw = (rng.integers(2) + turned / 2) * np.pi
                parts += _placed(model, (*place, floor + level + model.size[2] / 2), yaw)
                mass += model.mass
        level += float(model.size[2]) + 0.0005


def _placed(model: ObjectModel, centre: tuple[float, ...], yaw: float) -> list[Part]:
    T = make_transform(rotation_z(yaw), np.array(centre))
    return [replace(part, T_object_part=T @ part.T_object_part) for part in model.parts]
