"""What depth cameras and a LiDAR read of a load in stretch film: docs/images/sensors/film.jpg.

python -m docs.figures.film_sheet [--out DIR]
"""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import tyro
from jaxtyping import Float32, UInt8

from docs.figures.sensor_views import View, see
from warehouse_sim.dataset.viewing.overlay import draw_caption
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera, make_transform, rotation_z
from warehouse_sim.render import open_renderer
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import SceneSpec, Viewpoint
from warehouse_sim.sensors.film import FilmSight, see_film
from warehouse_sim.sensors.lidar import LIDAR_PRESETS, scan
from warehouse_sim.sensors.lidar.finishes import finishes_of
from warehouse_sim.sensors.rgbd.depth import PRESETS

OUT = Path(__file__).parents[1] / "images" / "sensors"
Image = UInt8[np.ndarray, "h w 3"]
CAMERA = PinholeCamera.from_focal(640, 480, 462.6)
DISTANCE, HEIGHT = 1.9, 0.8
SHRINK = 0.75
MOST_ERROR = 0.06
"""End of the scale of errors (m)."""


def main(out: Path = OUT, seed: int = 0) -> None:
    """Write the sheet.

    Args:
        out: Folder of the image.
        seed: Of the scene.
    """
    scene = before_film(seed)
    with open_renderer("raster") as renderer:
        view = see(scene, scene.viewpoints[0], renderer, CAMERA)
    film = see_film(FilmSight(scene), CAMERA, scene.viewpoints[0].T_world_camera, view.buffers.depth)
    rows = [[(view.buffers.rgb.copy(), "clean colour"), (lidar_view(scene, view), "os1_128: red = points on film")]]
    for name in ("d455", "tof_industrial"):
        errors = []
        for found, text in ((None, "without film"), (film, "with film")):
            capture = replace(view.capture, film=found)
            read = PRESETS[name].read(view.buffers, capture, np.random.default_rng(0))
            errors.append((error_colors(read, view.buffers.depth), f"{name}, {text}: error, +-60 mm, black = none"))
        rows.append(errors)
    sheet = np.concatenate([np.concatenate([_titled(*tile) for tile in row], axis=1) for row in rows])
    sheet = cv2.resize(sheet, None, fx=SHRINK, fy=SHRINK, interpolation=cv2.INTER_AREA)
    path = out / "film.jpg"
    cv2.imwrite(str(path), cv2.cvtColor(sheet, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, 82])
    print(f"{path}: {path.stat().st_size / 1000:.0f} kB")


def before_film(seed: int = 0) -> SceneSpec:
    """Return a staging scene with one viewpoint, level and before the side of a filmed load."""
    scene = prepare_scene(load_recipe("dock_staging"), seed, 0).scene
    films = [item for item in scene.instances if scene.models[item.model].class_name == "wrap"]
    others = np.array([item.T_world_object[:2, 3] for item in scene.target_instances()])

    def room(pose: np.ndarray) -> float:
        ahead = (others - pose[:2, 3]) @ pose[:2, 2]
        aside = np.abs((others - pose[:2, 3]) @ pose[:2, 0])
        return float(np.where((aside < 0.9) & (ahead > -0.6), ahead, 9.0).min())

    poses = []
    for film in films:
        for turn in (-np.pi / 2, np.pi / 2):
            away = rotation_z(turn) @ np.array([1.0, 0.0, 0.0])
            place = film.T_world_object[:3, 3] - away * (DISTANCE + scene.models[film.model].size[1] / 2)
            poses.append(level_camera(np.array([place[0], place[1], HEIGHT]), turn))
    pose = max(poses, key=room)
    return replace(scene, viewpoints=(Viewpoint(pose, exposure=scene.exposure),))


def lidar_view(scene: SceneSpec, view: View) -> Image:
    """Return the points of a sweep from the camera's place, over the darkened image."""
    pose = scene.viewpoints[0].T_world_camera
    forward = pose[:3, 2]
    T_world_lidar = make_transform(rotation_z(float(np.arctan2(forward[1], forward[0]))), pose[:3, 3])
    caster, config = RayCaster(scene), LIDAR_PRESETS["os1_128"]
    finishes = finishes_of(scene, caster.materials, config.brightness, np.random.default_rng(2))
    points = scan(caster, config, T_world_lidar, np.random.default_rng(0), finishes=finishes, film=FilmSight(scene))
    in_world = points.points @ T_world_lidar[:3, :3].T + T_world_lidar[:3, 3]
    in_camera = (in_world - pose[:3, 3]) @ pose[:3, :3]
    films = [item.instance_id for item in scene.instances if scene.models[item.model].class_name == "wrap"]
    image = view.buffers.rgb // 3
    ahead = in_camera[:, 2] > 0.3
    on_film = np.isin(points.instance_ids, films)[ahead]
    for (u, v), red, shade in zip(CAMERA.project(in_camera[ahead]), on_film, points.intensity[ahead], strict=True):
        if 0 <= u < CAMERA.width and 0 <= v < CAMERA.height:
            color = (255, 60, 50) if red else (int(80 + 175 * shade),) * 3
            cv2.circle(image, (round(u), round(v)), 2 if red else 1, color, -1)
    return image


def error_colors(read: Float32[np.ndarray, "h w"], clean: Float32[np.ndarray, "h w"]) -> Image:
    """Return errors from blue over white to red, black where nothing is read."""
    fraction = np.clip((read - clean) / MOST_ERROR, -1.0, 1.0)[..., None]
    red, blue = np.array([200.0, 30.0, 30.0]), np.array([30.0, 60.0, 200.0])
    mixed = 255.0 + np.maximum(fraction, 0) * (red - 255.0) + np.maximum(-fraction, 0) * (blue - 255.0)
    return np.where((read > 0)[..., None], mixed, 0.0).astype(np.uint8)


def _titled(image: Image, text: str) -> Image:
    image = np.ascontiguousarray(image)
    draw_caption(image, text)
    return image


if __name__ == "__main__":
    tyro.cli(main)
