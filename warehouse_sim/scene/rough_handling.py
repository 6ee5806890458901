"""Batter some of a scene's cartons: each gets another mesh of its own kind, and stays where and what it is."""

from dataclasses import replace

import numpy as np

from warehouse_sim.catalog.loads.carton_wear import CartonWearConfig, battered
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.schema import ObjectModel

_VARIANTS = 3
"""Battered shapes of one carton in a scene: renderers hold each shape once."""


def batter_cartons(draft: SceneDraft, wear: CartonWearConfig, rng: np.random.Generator) -> None:
    """Give a fraction of the cartons that can move a battered mesh; instance ids and places stay."""
    if wear.fraction == 0.0:
        return
    variants: dict[tuple[str, int], ObjectModel] = {}
    for place, item in enumerate(draft.instances):
        model = draft.models[item.model]
        if model.class_name != "carton" or not item.dynamic or rng.random() >= wear.fraction:
            continue
        key = (model.name, int(rng.integers(_VARIANTS)))
        if key not in variants:
            variants[key] = battered(model, wear, rng)
            draft.models[variants[key].name] = variants[key]
        draft.instances[place] = replace(item, model=variants[key].name)
    used = {item.model for item in draft.instances}
    for name in [name for name in draft.models if name not in used]:
        del draft.models[name]
