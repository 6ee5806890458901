"""Sites that are built for a test."""

from typing import Any

import numpy as np

from warehouse_sim.scene.building.hall import HallConfig
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.site import Layout, Site, build_site


def built(layout: Layout, seed: int = 0, **hall: Any) -> tuple[SceneDraft, Site]:
    """Return the draft of a layout in a hall, the default one unless settings are given, and what it offers."""
    draft = SceneDraft()
    return draft, build_site(draft, layout, HallConfig(**hall), np.random.default_rng(seed))
