"""Does any view look into nothing? Pixels without a surface in scenes of every recipe; the drawn outdoors has one.

    python -m benchmarks.acceptance.holes                       # every recipe, two scenes each, prints the rows
    python -m benchmarks.acceptance.holes --recipes demo smoke --scenes 5
    python -m benchmarks.acceptance.holes --write               # and stores results/holes.json

Pixels are counted where the raster backend's instance image says 0: what users get, cracks between parts included.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import tyro

from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim.catalog.building.outdoors import OUTDOORS
from warehouse_sim.errors import SettleError
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.sampled import sample_settled_scene
from warehouse_sim.render import open_renderer
from warehouse_sim.schema import SceneSpec, Viewpoint

UNROOFED = ("industrial-v1",)
"""The recipe whose halls stay as they were, for the estimators that were trained on it."""


def holes_of(recipe: str, scenes: int, seed: int) -> dict[str, object]:
    """Return the fraction of pixels of one recipe that show nothing, and that show the outdoors."""
    empty, outside, worst = [], [], 0.0
    with open_renderer("raster") as renderer:
        camera = load_recipe(recipe).sensors.make_camera()
        for scene, view in _views(recipe, scenes, seed):
            renderer.load(scene)
            ids = renderer.render(camera.pinhole, view.T_world_camera).instance_ids
            yard = [item.instance_id for item in scene.instances if scene.model_of(item).class_name == OUTDOORS]
            fraction = float((ids == 0).mean())
            worst = max(worst, fraction)
            empty.append(fraction)
            outside.append(float(np.isin(ids, yard).mean()))
    return {
        "name": recipe,
        "views": len(empty),
        "without_surface": float(np.mean(empty)),
        "worst_view": worst,
        "outdoors": float(np.mean(outside)),
    }


def _views(recipe: str, scenes: int, seed: int) -> Iterator[tuple[SceneSpec, Viewpoint]]:
    for index in range(scenes):
        try:
            scene = sample_settled_scene(load_recipe(recipe), seed, index).scene
        except SettleError:
            continue
        for view in scene.viewpoints:
            yield scene, view


def main(recipes: tuple[str, ...] = (), scenes: int = 2, seed: int = 15, write: bool = False) -> None:
    """Count pixels without a surface.

    Args:
        recipes: Names of recipes; all by default.
        scenes: Of each.
        seed: Seed of the scenes.
        write: Whether to store the result.
    """
    names = recipes or tuple(sorted(path.stem for path in Path("scenes").glob("*.yaml")))
    rows = []
    for name in names:
        rows.append(rounded(holes_of(name, scenes, seed) | {"roofed": name not in UNROOFED}))
        print(rows[-1], flush=True)
    if write:
        write_result(RESULTS / "holes.json", "python -m benchmarks.acceptance.holes --write", rows, seed=seed)


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
