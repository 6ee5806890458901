"""One image of the whole catalog: each object alone on a floor, with its name and outer size."""

from collections.abc import Callable, Sequence
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog import catalog_names, catalog_object
from warehouse_sim.catalog.materials import materials_of
from warehouse_sim.catalog.parts import box_part
from warehouse_sim.dataset.files.image_io import encode_rgb
from warehouse_sim.dataset.viewing.overlay import Image
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert, level_camera, make_transform, transform_points
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.render import Renderer, open_renderer
from warehouse_sim.schema import Light, ObjectInstance, ObjectModel, SceneSpec, Viewpoint

WIDTH, HEIGHT, CAPTION = 320, 240, 44
"""Size of one thumbnail and of the caption under it (px)."""
COLUMNS = 6
_SAMPLES = 2
"""Pixels that are sampled for one that is shown, along each edge."""
_YAW, _PITCH = np.deg2rad(128.0), np.deg2rad(-22.0)
"""Heading and tilt of the camera: the faces at -y and +x, and the top."""
_MARGIN = 0.9
"""Fraction of the thumbnail that an object fills."""
_ILLUMINANCE = 500.0
"""What the main light gives at the object (lx)."""


def render_catalog_sheet(
    out: Path,
    names: Sequence[str] | None = None,
    columns: int = COLUMNS,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> None:
    """Draw catalog objects side by side and write the sheet as PNG.

    Args:
        out: PNG file.
        names: Catalog objects; all, in order of their numbers, by default.
        columns: Thumbnails in a row, >= 1.
        progress: Called with how many are rendered, and how many there are.

    Raises:
        UnknownNameError: A name is not in the catalog.
    """
    models = [catalog_object(name) for name in (catalog_names() if names is None else names)]
    if names is None:
        models.sort(key=lambda model: (model.obj_id, model.name))
    cells = list[Image]()
    with open_renderer("raster") as renderer:
        for model in models:
            cells.append(captioned(render_thumbnail(renderer, model), model))
            progress(len(cells), len(models))
    make_folder(out.parent)
    write_bytes(out, encode_rgb(_grid(cells, columns)))


def render_thumbnail(renderer: Renderer, model: ObjectModel) -> Image:
    """Return an image of ``model`` on a floor, seen from above one of its corners and filling the image."""
    camera = PinholeCamera.from_focal(WIDTH * _SAMPLES, HEIGHT * _SAMPLES, 2.2 * WIDTH * _SAMPLES)
    T_world_camera = _framing_pose(model, camera)
    renderer.load(_thumbnail_scene(model, T_world_camera))
    sampled = renderer.render(camera, T_world_camera).rgb
    return cv2.resize(sampled, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)


def captioned(thumbnail: Image, model: ObjectModel) -> Image:
    """Return the thumbnail over a band with name, outer size, mass and class."""
    band = np.full((CAPTION, WIDTH, 3), 24, np.uint8)
    size = " x ".join(f"{np.round(1000 * edge, 1):g}" for edge in model.size)
    mass = f", {np.round(model.mass, 2):g} kg" if model.mass else ""
    for text, line, level in ((model.name, 17, 255), (f"{model.class_name}: {size} mm{mass}", 35, 180)):
        scale = min(0.45, 0.45 * (WIDTH - 12) / cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, 0.45, 1)[0][0])
        cv2.putText(band, text, (6, line), cv2.FONT_HERSHEY_SIMPLEX, scale, (level,) * 3, 1, cv2.LINE_AA)
    return np.concatenate([thumbnail, band])


def _framing_pose(model: ObjectModel, camera: PinholeCamera) -> Transform:
    """Return the pose of a camera that sees the whole object, centred, as large as the margin allows."""
    T_world_camera = level_camera(np.zeros(3), _YAW, _PITCH)
    points = transform_points(invert(T_world_camera), _vertices(model))
    middle = np.array([camera.cx, camera.cy])
    half = _MARGIN * (middle + 0.5)
    x, y = ((points[:, axis].max() + points[:, axis].min()) / 2 for axis in (0, 1))
    distance = float(np.linalg.norm(model.size))
    for _ in range(20):  # pixels depend on the distance, and the distance on pixels: this settles in a few rounds
        pixels = camera.project(points - np.array([x, y, -distance])) - middle
        low, high = pixels.min(axis=0), pixels.max(axis=0)
        x, y = np.array([x, y]) + (low + high) / 2 * distance / camera.fx
        distance = float(max(distance * ((high - low) / 2 / half).max(), 0.1 - points[:, 2].min()))
    return T_world_camera @ make_transform(translation=np.array([x, y, -distance]))


def _thumbnail_scene(model: ObjectModel, T_world_camera: Transform) -> SceneSpec:
    """Return the scene: the object about the world's origin, a floor under it, and lights as far as it is large."""
    reach = float(np.linalg.norm(model.size)) + 0.5
    low = _vertices(model)[:, 2].min()
    floor_size = (60.0 * reach, 60.0 * reach, 0.1)
    slab = box_part(floor_size, (0.0, 0.0, 0.0), "concrete")
    floor = ObjectModel("stage floor", "floor", 1, np.array(floor_size), (slab,), ())
    T_world_floor = make_transform(translation=np.array([0.0, 0.0, low - 0.051]))
    return SceneSpec(
        scene_index=0,
        seed=0,
        models={item.name: item for item in (model, floor)},
        materials=materials_of((model, floor)),
        instances=(ObjectInstance(1, floor.name, T_world_floor), ObjectInstance(2, model.name, np.eye(4))),
        lights=tuple(
            _light(place, fraction, reach) for place, fraction in (((0.9, -0.9, 1.9), 1.0), ((1.6, 1.2, 1.0), 0.35))
        ),
        viewpoints=(Viewpoint(T_world_camera),),
        ambient=0.35 * _ILLUMINANCE,
        exposure=np.pi / (1.6 * _ILLUMINANCE),
    )


def _light(place: tuple[float, float, float], fraction: float, reach: float) -> Light:
    """Return a spot at ``place`` times ``reach`` (m) that gives ``fraction`` of the illuminance at the origin."""
    position = np.array(place) * 1.5 * reach
    distance = float(np.linalg.norm(position))
    return Light(
        "spot", position, -position / distance, fraction * _ILLUMINANCE * distance**2, (1.0, 1.0, 1.0), 0.8, 1.2
    )


def _vertices(model: ObjectModel) -> Float[np.ndarray, "n 3"]:
    return np.concatenate([part.placed().vertices for part in model.parts])


def _grid(cells: list[Image], columns: int) -> Image:
    """Return the cells in rows; the last row is filled up with dark ones."""
    columns = min(columns, len(cells))
    empty = np.full_like(cells[0], 24)
    cells = cells + [empty] * (-len(cells) % columns)
    return np.concatenate(
        [np.concatenate(cells[start : start + columns], axis=1) for start in range(0, len(cells), columns)]
    )
