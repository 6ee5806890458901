"""What the RGB-D models make of one view, and how their noise compares with what was published.

python -m docs.figures.sensor_sheets [--out DIR] writes docs/images/sensors/: depth.jpg, color.jpg, depth_sigma.png.
"""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import tyro
from jaxtyping import Float32, UInt8

from docs.figures.sensor_sigma import draw_sigma
from docs.figures.sensor_views import CAMERA, View, scene_before_pallet, see
from warehouse_sim.dataset.viewing.overlay import draw_caption
from warehouse_sim.render import open_renderer
from warehouse_sim.sensors.motion import Motion
from warehouse_sim.sensors.rgbd.color import COLOR_PRESETS, IDEAL_COLOR, ColorConfig, read_color
from warehouse_sim.sensors.rgbd.depth import PRESETS

OUT = Path(__file__).parents[1] / "images" / "sensors"
Image = UInt8[np.ndarray, "h w 3"]
NEAR, FAR, MOST_ERROR = 1.0, 4.0, 0.06
"""Ends of the scale of depth, and of that of its error (m)."""
SHRINK = 0.7


def depth_sheet(view: View) -> Image:
    """Return a row a camera: what it reads, and by how much that is wrong."""
    clean = view.buffers.depth
    rows = [[view.buffers.rgb.copy(), depth_colors(clean)]]
    captions = [["clean colour", f"clean depth, {NEAR:g}-{FAR:g} m"]]
    for name, model in PRESETS.items():
        read = model.read(view.buffers, view.capture, np.random.default_rng(0))
        rows.append([depth_colors(read), error_colors(read, clean)])
        captions.append(
            [f"{name}: {model.kind}", f"error, blue -{1000 * MOST_ERROR:g} mm, red +{1000 * MOST_ERROR:g} mm"]
        )
    for images, texts in zip(rows, captions, strict=True):
        for image, text in zip(images, texts, strict=True):
            draw_caption(image, text)
    tiles = [np.concatenate(images, axis=0) for images in rows]
    return np.concatenate([np.concatenate(tiles[start : start + 3], axis=1) for start in (0, 3)])


def depth_colors(depth: Float32[np.ndarray, "h w"]) -> Image:
    """Return depth in colours, black where there is none."""
    fraction = np.clip((depth - NEAR) / (FAR - NEAR), 0.0, 1.0)
    colors = cv2.applyColorMap((255 * (1.0 - fraction)).astype(np.uint8), cv2.COLORMAP_TURBO)[..., ::-1].copy()
    colors[depth == 0] = 0
    return colors


def error_colors(read: Float32[np.ndarray, "h w"], clean: Float32[np.ndarray, "h w"]) -> Image:
    """Return errors from blue over white to red, black where nothing is read."""
    fraction = np.clip((read - clean) / MOST_ERROR, -1.0, 1.0)[..., None]
    red, blue = np.array([200.0, 30.0, 30.0]), np.array([30.0, 60.0, 200.0])
    mixed = 255.0 + np.maximum(fraction, 0) * (red - 255.0) + np.maximum(-fraction, 0) * (blue - 255.0)
    return np.where((read > 0)[..., None], mixed, 0.0).astype(np.uint8)


def color_sheet(view: View) -> Image:
    """Return crops of one image through single settings of the colour camera."""
    alone = IDEAL_COLOR
    noise = replace(alone, noise_scale=1.0)
    moving = replace(view.capture, motion=Motion(np.array([0.6, 0.0, 1.5]), np.array([0.0, 0.3, 0.0])))
    dim = replace(view.capture, exposure_ev=4.0)
    passing = replace(view.capture, motion=Motion(np.array([1.5, 0.0, 0.0])))
    cases = [
        ("clean", alone, view.capture),
        ("as by default", ColorConfig(), view.capture),
        ("EV 4, as by default", ColorConfig(), dim),
        ("EV 4, raw", COLOR_PRESETS["raw"], dim),
        ("EV 4, noise alone", noise, dim),
        ("1.5 m/s ahead, 0.6 m/s aside, 17 deg/s, 10 ms", replace(alone, motion_blur=True), moving),
        ("1.5 m/s aside, rolling shutter of 30 ms", replace(alone, rolling_shutter_ms=30.0), passing),
        ("glare 0.2, saturation 0.5", replace(alone, glare=0.2, saturation=0.5), view.capture),
        ("JPEG 40", replace(alone, jpeg_quality=40), view.capture),
    ]
    tiles = []
    for text, config, capture in cases:
        tiles.append(read_color(view.buffers, capture, config, np.random.default_rng(1)).copy())
        draw_caption(tiles[-1], text)
    return np.concatenate([np.concatenate(tiles[start : start + 3], axis=1) for start in (0, 3, 6)])


def main(out: Path = OUT) -> None:
    """Write the sheets.

    Args:
        out: Folder of the images.
    """
    out.mkdir(parents=True, exist_ok=True)
    scene = scene_before_pallet()
    with open_renderer("raster") as renderer:
        view = see(scene, scene.viewpoints[0], renderer, CAMERA)
    for name, sheet in (("depth", depth_sheet(view)), ("color", color_sheet(view))):
        path = out / f"{name}.jpg"
        sheet = cv2.resize(sheet, None, fx=SHRINK, fy=SHRINK, interpolation=cv2.INTER_AREA)
        cv2.imwrite(str(path), cv2.cvtColor(sheet, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, 84])
        print(f"{path}: {path.stat().st_size / 1000:.0f} kB")
    draw_sigma(out / "depth_sigma.png")


if __name__ == "__main__":
    tyro.cli(main)
