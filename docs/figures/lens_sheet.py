"""What a lens does to an image and to its labels, and what is wrong with labels that know nothing of it.

python -m docs.figures.lens_sheet [--out DIR] writes docs/images/sensors/lens.jpg.
"""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import tyro
from jaxtyping import UInt8

from docs.figures.sensor_sheets import OUT
from docs.figures.sensor_views import scene_before_pallet
from warehouse_sim.dataset.viewing.overlay import colorize_depth, draw_box_3d, draw_caption
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render import open_renderer
from warehouse_sim.render.renderer import Renderer
from warehouse_sim.schema import Observation, SceneSpec, Viewpoint
from warehouse_sim.sensors.rgbd import RgbdConfig
from warehouse_sim.sensors.rgbd.color import IDEAL_COLOR
from warehouse_sim.sensors.rig import CAMERA_PRESETS, RigConfig

Image = UInt8[np.ndarray, "h w 3"]
YELLOW, CYAN, RED = (255, 210, 0), (0, 230, 255), (255, 60, 60)
PANEL_WIDTH = 800


def aisle_scene() -> SceneSpec:
    """Return a scene seen from its aisle at 1.9 m, level, along racks on one side."""
    scene = scene_before_pallet(distance=3.2, height=1.9)
    (view,) = scene.viewpoints
    pose = level_camera(view.T_world_camera[:3, 3] + [-1.0, 0.0, 0.0], np.pi / 2 - 0.75)
    return replace(scene, viewpoints=(Viewpoint(pose, exposure=view.exposure),))


def labelled(observation: Observation, camera: PinholeCamera | None = None) -> Image:
    """Return the image with boxes in space, boxes and outlines of what is visible.

    Args:
        observation: What was seen.
        camera: By which boxes in space are drawn, the observation's own by default; with another one they are all.
    """
    image = observation.rgbd.rgb.copy()
    for item in observation.annotations:
        if item.visible_fraction < 0.1:
            continue
        draw_box_3d(image, camera or observation.camera, item.T_camera_object, item.size, RED if camera else YELLOW, 2)
        if camera is None and item.box_visible_xyxy is not None:
            left, top, right, bottom = item.box_visible_xyxy
            cv2.rectangle(image, (left, top), (right, bottom), (255, 255, 255), 1)
            visible = (observation.buffers.instance_mask == item.instance_id).astype(np.uint8)
            outlines, _ = cv2.findContours(visible, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
            cv2.drawContours(image, outlines, -1, CYAN, 1)
    return image


def rows(scene: SceneSpec, name: str, renderer: Renderer) -> list[Image]:
    """Return one preset's panels, two by two."""
    config = CAMERA_PRESETS[name]
    rig = RigConfig(camera=config, rgbd=RgbdConfig(color=IDEAL_COLOR), lidar=None)
    (straight,) = observe_scene(scene, replace(rig, camera=replace(config, distortion=None)), renderer)
    (seen,) = observe_scene(scene, rig, renderer)
    panels = {
        f"{name} without its lens": labelled(straight),
        f"{name}: boxes in space, visible masks, 2D boxes": labelled(seen),
        "depth": colorize_depth(seen.buffers.depth, 1.5, 12.0),
        "boxes left behind: the same poses by K alone": labelled(seen, seen.camera.pinhole),
    }
    tiles = []
    for text, panel in panels.items():
        height = round(panel.shape[0] * PANEL_WIDTH / panel.shape[1])
        tiles.append(cv2.resize(panel, (PANEL_WIDTH, height), interpolation=cv2.INTER_AREA))
        draw_caption(tiles[-1], text)
    return [np.concatenate(tiles[start : start + 2], axis=1) for start in (0, 2)]


def main(out: Path = OUT) -> None:
    """Write the sheet.

    Args:
        out: Folder of the image.
    """
    out.mkdir(parents=True, exist_ok=True)
    scene = aisle_scene()
    with open_renderer("raster") as renderer:
        sheet = np.concatenate([row for name in ("wide", "kitti_raw") for row in rows(scene, name, renderer)])
    path = out / "lens.jpg"
    cv2.imwrite(str(path), cv2.cvtColor(sheet, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, 82])
    print(f"{path}: {path.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    tyro.cli(main)
