"""The same views by the raster backend and path traced, side by side: docs/images/photoreal.jpg.

python -m docs.figures.photoreal_sheet [--out FILE]
"""

from pathlib import Path

import cv2
import numpy as np
import tyro

from warehouse_sim.dataset.viewing.overlay import draw_caption
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render import open_renderer

PICTURE = Path(__file__).parents[1] / "images" / "photoreal.jpg"
CAMERA = PinholeCamera.from_focal(640, 400, 430.0)
VIEWS = (("selective_rack", 4711, 5, 0), ("dock_staging", 0, 0, 0), ("mixed_pallets", 0, 1, 0))
"""Recipe, seed, scene and view of each row."""


def main(out: Path = PICTURE, samples: int = 16, quality: int = 82) -> None:
    """Write the sheet as JPEG.

    Args:
        out: Its file.
        samples: Paths a pixel.
        quality: JPEG quality, 1-100.
    """
    backends = {"raster": {}, f"{samples} paths, denoised": {"samples": samples, "denoise": True}}
    columns = []
    for caption, options in backends.items():
        images = []
        with open_renderer("pathtrace" if options else "raster", **options) as renderer:
            for name, seed, index, number in VIEWS:
                scene = prepare_scene(load_recipe(name), seed, index).scene
                view = scene.viewpoints[number]
                renderer.load(scene.seen_from(view))
                images.append(renderer.render(CAMERA, view.T_world_camera).rgb.copy())
        draw_caption(images[0], caption)
        columns.append(np.vstack(images))
    cv2.imwrite(str(out), np.hstack(columns)[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])
    print(f"{out}: {out.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    tyro.cli(main)
