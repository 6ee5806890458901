"""One view in the light of every preset, side by side: docs/images/light.jpg.

python -m docs.figures.light_sheet [--out FILE]
"""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import tyro
from jaxtyping import UInt8

from warehouse_sim.dataset.viewing.overlay import draw_caption
from warehouse_sim.generation.light import LightMeter, light_scene, measure_conditions
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import sample_settled_scene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render import open_renderer
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.lighting.config import PRESETS, LightingConfig
from warehouse_sim.scene.streams import scene_rng
from warehouse_sim.schema import Viewpoint

PICTURE = Path(__file__).parents[1] / "images" / "light.jpg"
CAMERA = PinholeCamera.from_focal(760, 428, 400.0)
RECIPE, SEED, INDEX = "dock_staging", 0, 0
VIEW = Viewpoint(level_camera(np.array([-13.0, -4.0, 2.4]), np.deg2rad(20.0)))
COLUMNS = 2


def tiles() -> list[UInt8[np.ndarray, "h w 3"]]:
    """Return one image a preset, and a last one with its numbers."""
    settled = sample_settled_scene(load_recipe(RECIPE), SEED, INDEX).scene
    settled = replace(settled, viewpoints=(VIEW,))
    caster, images, lines = RayCaster(settled), [], []
    with open_renderer("raster") as renderer:
        for preset in PRESETS:
            rng = scene_rng(SEED, INDEX, "lighting")
            scene = light_scene(settled, LightingConfig(preset=preset), caster, CAMERA, rng)
            view = scene.viewpoints[0]
            renderer.load(scene.seen_from(view))
            images.append(renderer.render(CAMERA, view.T_world_camera).rgb.copy())
            draw_caption(images[-1], preset)
            measured = measure_conditions(LightMeter(scene, caster), view)
            lines.append(f"{preset:<14}{measured.floor_lux:8.1f} lx   EV {measured.exposure_ev:5.2f}")
    board = np.full_like(images[0], 24)
    for row, line in enumerate(["mean of the aisle's floor, exposure:", "", *lines]):
        for column, text in enumerate((line[:14], line[14:]) if row > 1 else (line,)):
            at = (40 + 230 * column, 70 + 36 * row)
            cv2.putText(board, text.strip(), at, cv2.FONT_HERSHEY_SIMPLEX, 0.7, (230, 230, 230), 1, cv2.LINE_AA)
    return [*images, board]


def main(out: Path = PICTURE) -> None:
    """Write the sheet as JPEG.

    Args:
        out: Its file.
    """
    images = tiles()
    rows = [np.concatenate(images[start : start + COLUMNS], axis=1) for start in range(0, len(images), COLUMNS)]
    sheet = cv2.cvtColor(np.concatenate(rows), cv2.COLOR_RGB2BGR)
    cv2.imwrite(str(out), sheet, [cv2.IMWRITE_JPEG_QUALITY, 86])
    print(f"{out}: {out.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    tyro.cli(main)
