"""Where on the floor light is measured."""

import numpy as np
from jaxtyping import Float

from warehouse_sim.scene.draft import Area
from warehouse_sim.schema import SceneSpec

_ALONG, _ACROSS = 12, 6


def floor_points(scene: SceneSpec) -> Float[np.ndarray, "n 3"]:
    """Return a grid of points on the aisle's floor (m).

    Raises:
        ValueError: The scene does not say where its aisle is.
    """
    if scene.aisle is None:
        raise ValueError(f"scene {scene.scene_index} has no aisle whose light could be measured; set SceneSpec.aisle")
    area = Area(*scene.aisle)
    x = area.x_min + (np.arange(_ALONG) + 0.5) / _ALONG * (area.x_max - area.x_min)
    y = area.y_min + (np.arange(_ACROSS) + 0.5) / _ACROSS * (area.y_max - area.y_min)
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    return np.column_stack([grid, np.full(len(grid), 0.01)])
