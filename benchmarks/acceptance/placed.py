"""Is every object of the catalog placed somewhere? Draws scenes of each recipe and names models that none holds.

    python -m benchmarks.acceptance.placed                        # prints what each recipe shows and what none does
    python -m benchmarks.acceptance.placed --scenes 60 --write    # more scenes, and stores the result

Drafts are read, since settling adds and takes away nothing. A battered, worn or relabelled object counts as what it
was, and one that is built to size as the catalog's of the same number (obj_id) and of fixed size.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import tyro

from benchmarks.acceptance.crush import FROZEN
from benchmarks.result import RESULTS, write_result
from warehouse_sim.catalog import SHIPPED, catalog_object
from warehouse_sim.errors import PlacementError
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.resources import data_folder
from warehouse_sim.scene import sample_scene
from warehouse_sim.schema import ObjectModel, SceneSpec


@dataclass(frozen=True)
class Seen:
    """What the scenes of one recipe hold."""

    recipe: str
    scenes: int
    names: frozenset[str]
    """Names of the models, without the tag of a single piece."""
    obj_ids: frozenset[int]


def look_at(recipe: Recipe, scenes: int, seed: int) -> Seen:
    """Draw ``scenes`` scenes of a recipe and note what is in them."""
    # Views cost time and place nothing.
    plain = replace(recipe, scene=replace(recipe.scene, observations_per_scene=1))
    found = list(_drafts(plain, scenes, seed))
    models = [model for scene in found for model in _used(scene)]
    names = frozenset(model.name.partition("~")[0] for model in models)
    return Seen(recipe.name, len(found), names, frozenset(model.obj_id for model in models))


def never_placed(seen: list[Seen]) -> list[str]:
    """Return the catalog names that nothing seen is called by or numbered like."""
    names = frozenset().union(*(item.names for item in seen))
    obj_ids = frozenset().union(*(item.obj_ids for item in seen))
    return [name for name in sorted(SHIPPED) if name not in names and catalog_object(name).obj_id not in obj_ids]


def shipped_recipes() -> list[str]:
    """Return the names of the recipes that are not frozen."""
    return sorted(path.stem for path in data_folder("scenes").glob("*.yaml") if path.stem not in FROZEN)


def _drafts(recipe: Recipe, scenes: int, seed: int) -> Iterator[SceneSpec]:
    for index in range(scenes):
        try:
            yield sample_scene(recipe.scene, seed, index)
        except PlacementError as problem:
            print(problem, flush=True)


def _used(scene: SceneSpec) -> list[ObjectModel]:
    return [scene.models[name] for name in sorted({item.model for item in scene.instances})]


def main(recipes: tuple[str, ...] = (), scenes: int = 20, seed: int = 0, write: bool = False) -> None:
    """Look and print.

    Args:
        recipes: Names or paths of recipes; all that ship by default, without the frozen ones.
        scenes: Scenes of each; rare things need many.
        seed: Seed of the dataset.
        write: Store the result file.
    """
    seen: list[Seen] = []
    for name in recipes or shipped_recipes():
        seen.append(look_at(load_recipe(name), scenes, seed))
        print(f"{name}: {len(seen[-1].names)} models in {seen[-1].scenes} scenes", flush=True)
    missing = never_placed(seen)
    print(
        f"output: {len(missing)} of {len(SHIPPED)} catalog objects are placed nowhere: {', '.join(missing) or 'none'}"
    )
    if write:
        rows: list[dict[str, Any]] = [
            {"name": item.recipe, "scenes": item.scenes, "models": len(item.names)} for item in seen
        ]
        rows.append({"name": "catalog", "objects": len(SHIPPED), "placed nowhere": len(missing)})
        command = f"python -m benchmarks.acceptance.placed --scenes {scenes} --seed {seed} --write"
        write_result(RESULTS / "placed.json", command, rows)


if __name__ == "__main__":
    tyro.cli(main)
