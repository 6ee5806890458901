"""Sites that are built for a test."""

import numpy as np

from warehouse_sim.scene.building.hall import HallConfig
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.site import Layout, Site, build_site


def built(layout: Layout, seed: int = 0) -> tuple[SceneDraft, Site]:
    """Return the draft of a layout in the default hall, and what it offers."""
    draft = SceneDraft()
    return draft, build_site(draft, layout, HallConfig(), np.random.default_rng(seed))
