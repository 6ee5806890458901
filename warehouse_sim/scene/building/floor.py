"""Where tracks, stains, patches and water lie on the floor."""

import numpy as np

from warehouse_sim.catalog.building.floor_marks import STAINS, VARIANTS, floor_stain, tyre_tracks
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.scene.draft import Area, SceneDraft

_LIFT = 0.0003
"""Height of the lowest film above the floor, and of each above the one before it (m)."""


def wear_floor(draft: SceneDraft, counts: dict[str, int], area: Area, rng: np.random.Generator) -> None:
    """Leave ``counts`` of "tracks", "stain", "patch" and "water" on the floor of ``area``."""
    z = _LIFT
    for kind in ("patch", "stain", "water"):
        for _ in range(counts[kind]):
            model = floor_stain(next(item for item in STAINS if item == kind), int(rng.integers(VARIANTS)))
            x, y = rng.uniform(area.x_min, area.x_max), rng.uniform(area.y_min, area.y_max)
            turn = 0.0 if kind == "patch" else rng.uniform(-np.pi, np.pi)
            at = np.array([x, y, z + model.size[2] / 2])
            draft.add(model, make_transform(rotation_z(turn), at))
            z += 0.00002
    if counts["tracks"]:
        length, width = round(area.x_max - area.x_min, 1), round(area.y_max - area.y_min, 1)
        model = tyre_tracks(length, width, counts["tracks"], int(rng.integers(VARIANTS)))
        at = np.array([(area.x_min + area.x_max) / 2, (area.y_min + area.y_max) / 2, z + model.size[2] / 2])
        draft.add(model, make_transform(translation=at))
