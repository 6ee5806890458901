"""Write YOLO: a data set a task, an image and a label file an observation each.

Rows of labels are class number, then fractions of the image's width and height, each 0 to 1.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from functools import cached_property, partial
from typing import Any

import cv2
import numpy as np
import yaml
from jaxtyping import Bool, Float, Float32

from warehouse_sim.dataset.formats.built_in import EachWriter, WriterBase, remove_file
from warehouse_sim.dataset.formats.observation_files import LabelledTarget, ObservationFiles
from warehouse_sim.dataset.formats.yolo import TASKS, Task, YoloLayout, yolo_layout
from warehouse_sim.dataset.formats.yolo.polygons import mask_polygon
from warehouse_sim.dataset.layout import observation_name
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.schema import ObjectModel, Pocket, SceneSpec
from warehouse_sim.schema.classes import numbered

_OUTSIDE = 1e-6
"""How far (px) a corner may leave the image by rounding."""


def oriented_box(mask: Bool[np.ndarray, "h w"]) -> Float[np.ndarray, "4 2"]:
    """Return the corners (x, y), in pixels from the image's outer corner, around the set pixels of a mask, whole.

    One side of the smallest rectangle lies along the convex hull (Freeman and Shapira 1975). Rectangles that leave the
    image are passed over, since tools reject their corners; the upright one never does.

    Args:
        mask: Not empty.
    """
    hull = _hull(mask)
    sides = np.roll(hull, -1, axis=0) - hull
    angles = np.concatenate([[0.0], np.arctan2(sides[:, 1], sides[:, 0])])
    along = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    (a0, a1), (b0, b1) = ((np.min(hull @ axis.T, axis=0), np.max(hull @ axis.T, axis=0)) for axis in (along, across))
    ends = np.stack([np.stack(pair, axis=1) for pair in ((a0, b0), (a1, b0), (a1, b1), (a0, b1))], axis=1)
    corners = ends[..., :1] * along[:, None] + ends[..., 1:] * across[:, None]
    size_wh = np.array([mask.shape[1], mask.shape[0]])
    inside = ((corners >= -_OUTSIDE) & (corners <= size_wh + _OUTSIDE)).all(axis=(1, 2))
    areas = np.where(inside, (a1 - a0) * (b1 - b0), np.inf)
    best: Float[np.ndarray, "4 2"] = np.clip(corners[int(np.argmin(areas))], 0.0, size_wh)
    return best


def _hull(mask: Bool[np.ndarray, "h w"]) -> Float[np.ndarray, "n 2"]:
    """Return the convex hull of the outer corners of the set pixels."""
    box = mask_box_xyxy(mask)
    assert box is not None
    left, top, right, bottom = box
    window = mask[top : bottom + 1, left : right + 1]
    rows = np.flatnonzero(window.any(axis=1))
    first, last = window[rows].argmax(axis=1), window.shape[1] - window[rows, ::-1].argmax(axis=1)
    ends = [(x + left, y + top + edge) for x in (first, last) for y, edge in ((rows, 0), (rows, 1))]
    points = np.concatenate([np.stack(item, axis=1) for item in ends]).astype(np.int32)
    hull: Float[np.ndarray, "n 2"] = cv2.convexHull(points)[:, 0].astype(float)
    return hull


CORNERS = 4
"""Of a pocket's opening."""
_MIRRORED = (1, 0, 3, 2)
"""Which corner takes the place of each in the mirror."""
_BEFORE = 0.02
"""Metres by which a surface must be nearer than a corner to hide it."""
_NEAR = 0.05
OUTSIDE, HIDDEN, VISIBLE = 0, 1, 2
"""Flags of a point: not in the image, in it and hidden, seen."""


def points_of(pockets: Sequence[Pocket]) -> int:
    """Return how many key points the fullest side of an object has."""
    return CORNERS * max((len(side) for side in _sides(pockets)), default=0)


def mirrored(count: int) -> list[int]:
    """Return for each of ``count`` points the one that takes its place in the mirror."""
    pockets = count // CORNERS
    return [CORNERS * (pockets - 1 - pocket) + corner for pocket in range(pockets) for corner in _MIRRORED]


def key_points(
    pockets: Sequence[Pocket],
    T_camera_object: Transform,
    camera: PinholeCamera,
    depth: Float32[np.ndarray, "h w"],
    count: int,
) -> Float[np.ndarray, "count 3"]:
    """Return u, v (px, pixel centres at integers) and flag of each key point; zeros where there is none.

    Args:
        pockets: Those of the object.
        T_camera_object: Its pose.
        camera: That of the image.
        depth: True depth of the image (m), 0 = nothing there.
        count: Points of a label; sides with fewer pockets fill the first places.
    """
    points = np.zeros((count, 3))
    corners = transform_points(T_camera_object, _facing_corners(pockets, invert(T_camera_object)[:3, 3]))
    for index, corner in enumerate(corners[:count]):
        place = _place(corner, camera)
        if place is not None:
            column, row = np.clip(np.rint(place), 0, [camera.width - 1, camera.height - 1]).astype(int)
            before = 0.0 < depth[row, column] < corner[2] - _BEFORE
            points[index] = *place, HIDDEN if before else VISIBLE
    return points


def _place(corner: Float[np.ndarray, " 3"], camera: PinholeCamera) -> Float[np.ndarray, " 2"] | None:
    """Return where a point of the camera frame is in the image; None if it is not."""
    if corner[2] < _NEAR:
        return None
    x, y = corner[:2] / corner[2]
    # Before the lens: its formula brings far points back into the image.
    left, right, top, bottom = camera.tangent_bounds()
    if not (left <= x <= right and top <= y <= bottom):
        return None
    u, v = camera.project(corner)
    inside = -0.5 <= u <= camera.width - 0.5 and -0.5 <= v <= camera.height - 0.5
    return np.array([u, v]) if inside else None


def _facing_corners(pockets: Sequence[Pocket], eye: Float[np.ndarray, " 3"]) -> Float[np.ndarray, "n 3"]:
    """Return the corners (m, object frame) on the side that faces the eye most; none if all look away."""
    best, most = np.zeros((0, 3)), 0.0
    for side in _sides(pockets):
        towards = eye - np.mean([pocket.T_object_pocket[:3, 3] for pocket in side], axis=0)
        cosine = float(-side[0].T_object_pocket[:3, 0] @ towards / max(np.linalg.norm(towards), 1e-9))
        if cosine > most:
            best, most = np.concatenate([_opening(pocket) for pocket in side]), cosine
    return best


def _sides(pockets: Sequence[Pocket]) -> list[list[Pocket]]:
    """Return the pockets of each side, from left to right as seen from before it."""
    by_face: dict[str, list[Pocket]] = defaultdict(list)
    for pocket in pockets:
        by_face[pocket.face].append(pocket)
    return [sorted(side, key=_rightness) for _, side in sorted(by_face.items())]


def _rightness(pocket: Pocket) -> float:
    """Return how far right a pocket lies (m): inwards is ahead and z is up, so that its y points to the left."""
    return -float(pocket.T_object_pocket[:3, 3] @ pocket.T_object_pocket[:3, 1])


def _opening(pocket: Pocket) -> Float[np.ndarray, "4 3"]:
    _, width, height = pocket.size / 2.0
    corners = np.array([[0.0, width, height], [0.0, -width, height], [0.0, -width, -height], [0.0, width, -height]])
    return transform_points(pocket.T_object_pocket, corners)


_DIGITS = 7


def box_row(number: int, box_xyxy: tuple[float, float, float, float], size_wh: tuple[int, int]) -> str:
    """Return class, centre and size of a box of inclusive pixel corners."""
    left, top, right, bottom = box_xyxy
    edges = np.array([[left, top], [right + 1, bottom + 1]]) / size_wh
    return _row(number, np.concatenate([edges.mean(axis=0), edges[1] - edges[0]]))


def corner_row(number: int, corners: Float[np.ndarray, "n 2"], size_wh: tuple[int, int]) -> str:
    """Return class and corners of a polygon or an oriented box, given in pixels from the image's outer corner."""
    return _row(number, (corners / size_wh).ravel())


def point_row(
    number: int,
    box_xyxy: tuple[float, float, float, float],
    points: Float[np.ndarray, "n 3"],
    size_wh: tuple[int, int],
) -> str:
    """Return class, box and key points with their flags; ``points`` have pixel centres at integers."""
    parts = [box_row(number, box_xyxy, size_wh)]
    for u, v, flag in points:
        fractions = np.clip((np.array([u, v]) + 0.5) / size_wh, 0.0, 1.0) if flag else np.zeros(2)
        parts.append(f"{_numbers(fractions)} {int(flag)}")
    return " ".join(parts)


def label_file(rows: Iterable[str]) -> bytes:
    """Return the file of all rows; equal ones are written once, since tools take the second one for an error."""
    return "".join(f"{row}\n" for row in dict.fromkeys(rows)).encode("ascii")


def _row(number: int, fractions: Sequence[float] | np.ndarray) -> str:
    return f"{number} {_numbers(np.clip(fractions, 0.0, 1.0))}"


def _numbers(fractions: Sequence[float] | np.ndarray) -> str:
    return " ".join(f"{fraction:.{_DIGITS}f}".rstrip("0").rstrip(".") for fraction in fractions)


class YoloWriter(WriterBase):
    """Write ``yolo/{detect,segment,pose,obb}``; no key points where no object of the dataset has pockets."""

    def begin(self, models: Sequence[ObjectModel], camera: PinholeCamera) -> None:
        """Make the folders and the descriptions."""
        for task, layout in self._layouts.items():
            for split in SPLITS:
                make_folder(layout.images(split))
                make_folder(layout.labels(split))
            write_bytes(layout.data, self._description(task).encode("utf-8"), durable=True)

    def scene(self, scene: SceneSpec) -> EachWriter:
        """Open a scene again."""
        split = self._manifest.split_of(scene.scene_index)
        for layout in self._layouts.values():
            for index in range(self._manifest.observations_per_scene):
                name = observation_name(scene.scene_index, index)
                remove_file(layout.images(split) / f"{name}.png")
                remove_file(layout.labels(split) / f"{name}.txt")
        return EachWriter(partial(self._write, split))

    @cached_property
    def _numbers(self) -> dict[str, int]:
        return {name: number for number, name in enumerate(numbered(self._manifest.targets))}

    @cached_property
    def _points(self) -> int:
        return max(points_of(info.pockets) for info in self._objects.values())

    @cached_property
    def _layouts(self) -> dict[Task, YoloLayout]:
        return {task: yolo_layout(self._root, task) for task in TASKS if task != "pose" or self._points}

    def _description(self, task: Task) -> str:
        """Return data.yaml; without ``path``, so that splits lie beside it wherever the folder is."""
        data: dict[str, Any] = {split: f"images/{split}" for split in SPLITS}
        data["names"] = {number: name for name, number in self._numbers.items()}
        if task == "pose":
            data |= {"kpt_shape": [self._points, 3], "flip_idx": mirrored(self._points)}
        return yaml.safe_dump(data, sort_keys=False, default_flow_style=None)

    def _write(self, split: str, files: ObservationFiles) -> None:
        """Write image and labels of one observation for each task.

        Raises:
            DatasetError: A target's class is not among those of the dataset.
        """
        observation = files.observation
        name = observation_name(observation.scene_index, observation.observation_index)
        for task, layout in self._layouts.items():
            files.rgb.save(layout.images(split) / f"{name}.png")
            rows = [self._row(task, files, target) for target in files.targets]
            write_bytes(layout.labels(split) / f"{name}.txt", label_file(rows))

    def _row(self, task: Task, files: ObservationFiles, target: LabelledTarget) -> str:
        annotation, camera = target.annotation, files.observation.camera
        number, size_wh = self._number(annotation.class_name, files), (camera.width, camera.height)
        box = target.box_visible_xyxy
        if task == "detect":
            return box_row(number, box, size_wh)
        if task == "segment":
            return corner_row(number, mask_polygon(target.mask_visible), size_wh)
        if task == "obb":
            return corner_row(number, oriented_box(target.mask_visible), size_wh)
        info, depth = self._objects.get(annotation.obj_id), files.observation.buffers.depth
        pockets = () if info is None else info.pockets
        points = key_points(pockets, annotation.T_camera_object, camera, depth, self._points)
        return point_row(number, box, points, size_wh)

    def _number(self, class_name: str, files: ObservationFiles) -> int:
        if class_name not in self._numbers:
            scene, index = files.observation.scene_index, files.observation.observation_index
            raise DatasetError(
                f"YOLO, scene {scene}, observation {index}: class {class_name} is not among the dataset's targets "
                f"{', '.join(self._numbers)}; add it to the recipe's targets"
            )
        return self._numbers[class_name]
