"""Scenes of halls with everything in them, for tests."""

from typing import Any

from warehouse_sim.config import from_mapping
from warehouse_sim.scene.recipe import SceneRecipe
from warehouse_sim.scene.sampling import sample_scene
from warehouse_sim.schema import SceneSpec

ALL_SERVICES = {
    **dict.fromkeys(
        ("sprinklers", "cable_trays", "ducts", "light_lines", "rooflights", "windows", "signs", "fire_equipment"), True
    ),
    **dict.fromkeys(("guards", "markings", "floor_labels"), True),
    "bins": 4,
    "floor_signs": 1,
}


def hall_scene(index: int = 0, layout: dict[str, Any] | None = None, lights: Any = None, **hall: Any) -> SceneSpec:
    """Return scene ``index`` of a hall with these settings, without loads."""
    plain = {
        "layout": layout or {"bays": 2, "beam_levels": [1.5], "aisle_width": 9.5},
        "hall": {"roof": True, **hall},
        "shelving": {"empty_slot_fraction": 1.0},
        "lanes": {"fill": 0.0},
        "staging": {"count": 2},
        "lights": lights or {},
        "viewpoints": {"distance": {"min": 2.0, "max": 6.0}},
        "observations_per_scene": 2,
    }
    return sample_scene(from_mapping(SceneRecipe, plain, "test"), 7, index)
