"""A recipe with one more object of the user's own: where it comes, and that it gets labels."""

from collections.abc import Sequence
from typing import Any, Literal

from warehouse_sim.catalog import catalog_object
from warehouse_sim.errors import RecipeError
from warehouse_sim.generation.recipe import Recipe, changed

Place = Literal["shelf", "pallet", "floor"]
"""On the shelves of the layout, stacked on pallets, standing on the floor of the aisle."""
_OTHER_GOODS = ("tote_fraction", "drum_fraction", "sack_fraction")


def with_own_object(
    recipe: Recipe, name: str, places: Sequence[Place], fraction: float, count: tuple[int, int]
) -> Recipe:
    """Return a recipe that has one more object, whose class is a target.

    A layout without bare shelves keeps its goods on pallets in racks: there, shelves are those.

    Args:
        recipe: What to add it to.
        name: Catalog name, or file as a recipe writes it.
        places: Where it comes.
        fraction: Of the loaded pallets, or of the shelves, that hold goods of the user's own, 0-1.
        count: Least and greatest number of the user's own things on the floor.

    Raises:
        RecipeError: No place, or one that does not take it.
    """
    if not places:
        raise RecipeError(f"places: {name} comes nowhere; name shelf, pallet or floor")
    if not 0.0 < fraction <= 1.0:
        raise RecipeError(f"fraction must be above 0 and at most 1, found {fraction}")
    model, scene = catalog_object(name), recipe.scene
    settings: dict[str, Any] = {"targets": list(dict.fromkeys((*scene.targets, model.class_name)))}
    if "floor" in places:
        low, high = count
        settings["traffic"] = {"objects": _joined(scene.traffic.objects, name), "own": {"min": low, "max": high}}
    loads: dict[str, Any] = {}
    has_shelves = hasattr(scene.layout, "goods_fraction")
    if "shelf" in places and has_shelves:
        settings["layout"] = {"goods_fraction": fraction}
    if "pallet" in places or ("shelf" in places and not has_shelves):
        others = sum(getattr(scene.loads, key) for key in _OTHER_GOODS)
        loads["goods_fraction"] = min(fraction, 1.0 - others)
    if set(places) != {"floor"}:
        if model.mass <= 0.0:
            raise RecipeError(f"{name}: has no mass, so that it cannot be stacked; give it one in its .yaml file")
        settings["loads"] = loads | {"goods": _joined(scene.loads.goods, name)}
    return changed(recipe, {"scene": settings})


def _joined(names: Sequence[str], name: str) -> list[str]:
    return list(dict.fromkeys((*names, name)))
