"""What the kitti rig reads of one view: the pair, its disparities, and the sweep on the image.

python -m docs.figures.rig_sheet [--out FILE] writes docs/images/sensors/rig.jpg.
"""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import tyro
from jaxtyping import Float, UInt8

from warehouse_sim.dataset.viewing.overlay import draw_caption
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import sample_settled_scene
from warehouse_sim.geometry.clouds import cloud_to_depth
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.render import open_renderer
from warehouse_sim.schema import Observation
from warehouse_sim.sensors.rig import RigConfig

OUT = Path(__file__).parents[1] / "images" / "sensors" / "rig.jpg"
Image = UInt8[np.ndarray, "h w 3"]
MOST_PX, FARTHEST = 190.0, 12.0
SHRINK = 0.65


def main(out: Path = OUT, recipe: str = "demo", view: int = 4) -> None:
    """Draw the sheet.

    Args:
        out: The file.
        recipe: Whose first scene is looked at.
        view: Number of its viewpoint.
    """
    rig = RigConfig.from_plain({"rig": "kitti"}, "rig_sheet")
    scene = sample_settled_scene(load_recipe(recipe), 0, 0).scene
    with open_renderer() as renderer:
        seen = next(observe_scene(replace(scene, viewpoints=scene.viewpoints[view : view + 1]), rig, renderer))
    assert seen.stereo is not None
    assert seen.stereo.matched is not None
    tiles = [
        (seen.rgbd.rgb, "image_2: left"),
        (seen.stereo.rgb, "image_3: right, 0.54 m beside"),
        (colors(seen.stereo.disparity / MOST_PX), f"disp_occ: true disparity, red = {MOST_PX:g} px"),
        (colors(seen.stereo.matched / MOST_PX), "disp_sgbm: matched, black = none"),
        (points_on_image(seen), f"velodyne on image_2 by the written calibration, red = 0, blue = {FARTHEST:g} m"),
        (colors(np.clip(1.0 - seen.rgbd.depth / FARTHEST, 0.01, 1.0) * (seen.rgbd.depth > 0)), "depth_2"),
    ]
    small = [cv2.resize(image, None, fx=SHRINK, fy=SHRINK, interpolation=cv2.INTER_AREA) for image, _ in tiles]
    for image, (_, caption) in zip(small, tiles, strict=True):
        draw_caption(image, caption)
    sheet = np.concatenate([np.concatenate(small[start : start + 2], axis=1) for start in (0, 2, 4)])
    cv2.imwrite(str(out), sheet[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 88])
    print(f"output: {out}")


def colors(fraction: Float[np.ndarray, "h w"]) -> Image:
    """Return fractions of 0-1 from blue to red, black at 0."""
    image = cv2.applyColorMap((255 * np.clip(fraction, 0, 1)).astype(np.uint8), cv2.COLORMAP_TURBO)[..., ::-1].copy()
    image[fraction <= 0] = 0
    return image


def points_on_image(seen: Observation) -> Image:
    """Return the left image, darkened, with the sweep's points in colours of their depth."""
    assert seen.lidar is not None
    points = transform_points(seen.T_camera_lidar, seen.lidar.points.astype(float))
    depth, _ = cloud_to_depth(points[points[:, 2] > 0.5], seen.camera)
    hit = cv2.dilate((depth > 0).astype(np.uint8), np.ones((2, 2), np.uint8)) > 0
    nearest = cv2.dilate(np.where(depth > 0, np.maximum(1.0 - depth / FARTHEST, 0.01), 0.0), np.ones((2, 2), np.uint8))
    return np.where(hit[..., None], colors(nearest), seen.rgbd.rgb // 2)


if __name__ == "__main__":
    tyro.cli(main)
