"""Where the time of generating a dataset goes: the generator itself is run, and its functions are watched."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.speed.cost import StageClock
from warehouse_sim.annotate.film import FilmCaster
from warehouse_sim.dataset.files import image_io, json_file
from warehouse_sim.dataset.formats import observation_files
from warehouse_sim.dataset.formats.kitti import writer as kitti
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.generation import generate as generator
from warehouse_sim.generation import observe
from warehouse_sim.generation.generate import GenerateConfig, generate
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.raster.backend import ImageTargets, RasterRenderer
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors import rgbd
from warehouse_sim.sensors.lidar import read as lidar

SCENE, DRAW, READ_BACK, ENCODE, DISK = "sample, settle and light", "draw", "read-back", "encode", "disk"
WRITE = "masks, tables, points"
"""What the writers do beside encoding images and putting files on the disk."""
_FUNCTIONS: list[tuple[Any, str, str]] = [
    (generator, "prepare_scene", SCENE),
    (observe, "RayCaster", "LiDAR"),
    (lidar, "scan", "LiDAR"),
    (rgbd, "read_rgbd", "sensor noise"),
    (observe, "targets_in_view", "labels"),
    (observe, "annotate", "labels"),
    (observe, "target_illuminance", "labels"),
    (observe, "measure_conditions", "labels"),
    (FilmCaster, "image", "labels"),
    (RasterRenderer, "load", "upload and indirect light"),
    (RasterRenderer, "render", DRAW),
    (RasterRenderer, "amodal_masks", "amodal masks"),
    (ImageTargets, "read", READ_BACK),
    (DatasetStore, "write_scene", WRITE),
    (image_io, "encode_png", ENCODE),
    (observation_files, "write_bytes", DISK),
    (observation_files, "hard_link", DISK),
    (json_file, "write_bytes", DISK),
    (kitti, "write_bytes", DISK),
]


@dataclass(frozen=True)
class SceneStages:
    """What one scene took."""

    seconds: dict[str, float]
    """Of each stage."""
    observations: int


def watch_generation(
    recipe: Recipe, config: GenerateConfig, out: Path, now: Callable[[], float] = time.process_time
) -> list[SceneStages]:
    """Generate a dataset in this process, drawing normals too; return the stages of all scenes but the first.

    The first scene warms up: shaders are compiled and textures loaded in it.

    Args:
        recipe: Where scenes are drawn from.
        config: How; one worker and the backend ``raster``.
        out: Folder of the dataset.
        now: The clock: CPU time of the process, or time that passes.
    """
    clock = StageClock(now)
    scenes: list[dict[str, float]] = []

    def progress(done: int, total: int) -> None:
        if done:
            scenes.append(dict(clock.seconds))
        clock.seconds.clear()

    with clock.watching(_FUNCTIONS), _with_normals(), _rendered_before_read():
        manifest = generate(recipe, out, config, progress)
    return [SceneStages(seconds, manifest.observations_per_scene) for seconds in scenes[1:]]


@contextmanager
def _with_normals() -> Iterator[None]:
    draw = RasterRenderer.render

    def draw_all(
        renderer: RasterRenderer, camera: PinholeCamera, T_world_camera: Transform, normals: bool = True
    ) -> RenderBuffers:
        return draw(renderer, camera, T_world_camera, normals=True)

    with _replaced(RasterRenderer, "render", draw_all):
        yield


@contextmanager
def _rendered_before_read() -> Iterator[None]:
    # Drivers draw when somebody requires the pixels: without waiting first, all drawing would count as read-back.
    read = ImageTargets.read

    def wait_and_read(targets: ImageTargets, *arguments: Any, **keywords: Any) -> Any:
        targets.color.ctx.finish()
        return read(targets, *arguments, **keywords)

    with _replaced(ImageTargets, "read", wait_and_read):
        yield


@contextmanager
def _replaced(owner: type, name: str, function: Callable[..., Any]) -> Iterator[None]:
    held = getattr(owner, name)
    setattr(owner, name, function)
    try:
        yield
    finally:
        setattr(owner, name, held)
