"""Draw the thumbnails of scenes/README.md: four views of each recipe, one a scene.

python -m docs.figures.recipe_sheets industrial approach    # some recipes; without names all that look like no other
"""

from pathlib import Path

import cv2
import numpy as np
import tyro

from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.render import open_renderer
from warehouse_sim.resources import find_recipe, recipe_names
from warehouse_sim.yaml_file import read_yaml

FOLDER = Path(__file__).parents[1] / "images" / "recipes"
WIDTH = 800
SCENES = 4


def main(recipes: tyro.conf.Positional[tuple[str, ...]] = (), seed: int = 0, quality: int = 82) -> None:
    """Write docs/images/recipes/NAME.jpg for each recipe.

    Args:
        recipes: Names of shipped recipes; all but smoke and those that extend another by default.
        seed: Seed of the scenes.
        quality: JPEG quality, 1-100.
    """
    with open_renderer("raster") as renderer:
        for name in recipes or [item for item in recipe_names() if _has_a_look_of_its_own(item)]:
            recipe, views = load_recipe(name), []
            for index in range(SCENES):
                prepared = prepare_scene(recipe, seed, index)
                observations = observe_scene(prepared.scene, recipe.sensors, renderer, prepared.variants)
                # Variants come one after the other: a step that is no multiple of the views shows several of them.
                wanted = index * (len(prepared.variants) // SCENES) * len(prepared.scene.viewpoints) + index
                view = next(item for item in observations if item.observation_index == wanted)
                height = round(WIDTH * view.camera.height / view.camera.width)
                views.append(cv2.resize(view.rgbd.rgb, (WIDTH, height), interpolation=cv2.INTER_AREA))
            sheet = np.vstack([np.hstack(views[:2]), np.hstack(views[2:])])
            path = FOLDER / f"{name}.jpg"
            cv2.imwrite(str(path), sheet[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])
            print(f"output: {path}")


def _has_a_look_of_its_own(recipe: str) -> bool:
    return recipe != "smoke" and "extends" not in read_yaml(find_recipe(recipe))


if __name__ == "__main__":
    tyro.cli(main)
