"""One dial from easy to hard: clutter, occlusion, light and noise move together."""

from typing import Any

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import RecipeError
from warehouse_sim.generation.recipe import Recipe

EASY_TO_HARD: dict[str, tuple[float, float]] = {
    "scene.traffic.people": (0, 2),
    "scene.traffic.pallet_jacks": (0, 1),
    "scene.traffic.trucks": (0, 2),
    "scene.traffic.cartons": (0, 3),
    "scene.traffic.cones": (0, 2),
    "scene.shelving.empty_slot_fraction": (0.5, 0.05),
    "scene.loads.damaged_fraction": (0.0, 0.5),
    "scene.loads.wrap_fraction": (0.0, 0.5),
    "occlusion.visible_fraction.min": (0.85, 0.1),
    "occlusion.visible_fraction.max": (1.0, 0.45),
    "scene.lights.lux": (300.0, 15.0),
    "sensors.rgbd.depth.noise_scale": (0.5, 4.0),
    "sensors.rgbd.color.noise_scale": (0.7, 1.4),
}
"""Keys of a recipe with their values at 0 and at 1. Light and noise move in equal factors, all else in equal steps."""
_COUNTS = "scene.traffic."
_IN_FACTORS = ("scene.lights.", "sensors.")


def with_difficulty(recipe: Recipe, difficulty: float) -> Recipe:
    """Return the recipe with the settings of ``EASY_TO_HARD`` moved to ``difficulty``; all others stay.

    Args:
        recipe: Where to start from.
        difficulty: 0 = easy, 1 = hard.

    Raises:
        RecipeError: The difficulty is not within 0-1, or the recipe cannot take a setting.
    """
    if not 0.0 <= difficulty <= 1.0:
        raise RecipeError(f"difficulty must be 0-1, found {difficulty}")
    plain = to_mapping(recipe)
    plain["scene"]["lights"]["flux"] = None  # lux and flux exclude each other
    visible = {end: _value(f"occlusion.visible_fraction.{end}", difficulty) for end in ("min", "max")}
    plain["occlusion"] = (plain["occlusion"] or {}) | {"visible_fraction": visible}
    for key in EASY_TO_HARD:
        if not key.startswith("occlusion."):
            for holder, inner in _holders(plain, key):
                _put(holder, inner, _value(key, difficulty))
    moved: Recipe = from_mapping(Recipe, plain, f"{recipe.name or 'recipe'} at difficulty {difficulty:g}")
    return moved


def _value(key: str, difficulty: float) -> float:
    easy, hard = EASY_TO_HARD[key]
    if key.startswith(_COUNTS):
        return round(easy + difficulty * (hard - easy))
    if key.startswith(_IN_FACTORS):
        return float(easy * (hard / easy) ** difficulty)
    return easy + difficulty * (hard - easy)


def _holders(plain: dict[str, Any], key: str) -> list[tuple[dict[str, Any], str]]:
    """Return where a key is: in the recipe, and what is a camera's setting in each one of those drawn from, too."""
    of_camera = key.removeprefix("sensors.rgbd.")
    choices = plain["sensors"].get("choices", []) if of_camera != key else []
    return [(plain, key), *((choice, of_camera) for choice in choices)]


def _put(plain: dict[str, Any], key: str, value: float) -> None:
    *parents, last = key.split(".")
    for parent in parents:
        plain = plain[parent]
    plain[last] = value
