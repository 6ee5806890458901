"""Pictures of what was estimated, for people: each pose as a box, or as the face and pockets that were measured."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.dataset.viewing.overlay import Image, colorize_depth, draw_box_3d, draw_caption, draw_segment
from warehouse_sim.errors import DatasetError
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.schema import PalletFace, PoseEstimate

_SURE, _UNSURE = (40, 230, 80), (255, 150, 30)
"""Colours of scores of a half and more, and of lower ones."""
_AXES = ((230, 40, 40), (60, 220, 60), (70, 110, 255))
_AXIS_M = 0.3
_TEXT = (255, 255, 120)
_LEAST_EDGE_PX = 640
"""Smaller images are enlarged."""


def write_pictures(
    folder: Path,
    reader: DatasetReader,
    images: Sequence[ImageRecord],
    estimates: Sequence[PoseEstimate],
    sizes: Mapping[int, Float[np.ndarray, " 3"]],
) -> None:
    """Write SCENE_IMAGE.png for each image.

    Args:
        folder: Where.
        reader: The dataset.
        images: Which of its images.
        estimates: Of any of them; rejected ones are left out.
        sizes: Edge lengths (m) of objects by number; of others axes are drawn.

    Raises:
        OutputError: The folder cannot be written.
    """
    make_folder(folder)
    for image in images:
        mine = [
            item
            for item in estimates
            if (item.scene_id, item.image_id) == (image.scene_id, image.image_id) and not item.rejected
        ]
        canvas, camera = _canvas(reader, image)
        for item in sorted(mine, key=lambda item: -float(item.T_camera_object[2, 3])):
            _draw(canvas, camera, item, sizes.get(item.obj_id))
        draw_caption(canvas, f"{image.scene_id}/{image.image_id}: {len(mine)} poses")
        _, png = cv2.imencode(".png", cv2.cvtColor(canvas, cv2.COLOR_RGB2BGR))
        write_bytes(folder / f"{image.scene_id:06d}_{image.image_id:06d}.png", png.tobytes())


def known_sizes(estimator: PoseEstimator, reader: DatasetReader) -> dict[int, Float[np.ndarray, " 3"]]:
    """Return the edge lengths (m) of objects by number: those of the dataset, and what an estimator has surfaces of."""
    found = {obj_id: np.ptp(mesh.vertices, axis=0) for obj_id, mesh in estimator.surfaces.items()}
    return found | {obj_id: info.size for obj_id, info in reader.objects.items() if np.all(info.size > 0)}


def _canvas(reader: DatasetReader, image: ImageRecord) -> tuple[Image, PinholeCamera]:
    try:
        canvas = reader.rgb(image)
    except DatasetError:
        canvas = colorize_depth(reader.depth(image))
    camera, scale = image.camera, max(1, -(-_LEAST_EDGE_PX // max(canvas.shape[:2])))
    size = camera.width * scale, camera.height * scale
    return cv2.resize(canvas, size, interpolation=cv2.INTER_CUBIC), camera.crop(0, 0, *size, scale)


def _draw(canvas: Image, camera: PinholeCamera, item: PoseEstimate, size: Float[np.ndarray, " 3"] | None) -> None:
    color = _SURE if item.score >= 0.5 else _UNSURE
    T = item.T_camera_object
    if item.face is not None:
        _draw_face(canvas, camera, item.face, color)
    elif size is not None:
        draw_box_3d(canvas, camera, T, size, color, 2)
    else:
        for axis, own in enumerate(_AXES):
            draw_segment(canvas, camera, T[:3, 3], T[:3, 3] + _AXIS_M * T[:3, axis], own, 2)
    if T[2, 3] > 0:
        u, v = np.clip(camera.project(T[None, :3, 3])[0], -1e4, 1e4).astype(int).tolist()
        text = f"{np.linalg.norm(T[:3, 3]):.1f} m, {100 * item.score:.0f} %"
        cv2.putText(canvas, text, (u - 40, v + 4), cv2.FONT_HERSHEY_SIMPLEX, 0.4, _TEXT, 1, cv2.LINE_AA)


def _draw_face(canvas: Image, camera: PinholeCamera, face: PalletFace, color: tuple[int, int, int]) -> None:
    """Draw the outline of the face, as wide as it was measured and centred on its pockets, and the openings."""
    width, height = face.size
    middle = np.array([face.pockets[:, 0].mean(), face.pockets[:, 1].mean()])
    for centre, (wide, high), line in (
        (middle, (width, height), 2),
        *((place, size, 2) for place, size in zip(face.pockets, face.pocket_sizes, strict=True)),
    ):
        sides = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array([wide, high]) / 2.0
        corners = transform_points(face.T_camera_dock, np.pad(centre + sides, ((0, 0), (1, 0))))
        for number in range(4):
            draw_segment(canvas, camera, corners[number], corners[(number + 1) % 4], color, line)
