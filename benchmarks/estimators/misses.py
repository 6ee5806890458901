"""Every object of a test split that an estimator puts beyond a tenth of its diameter, as images and as causes.

python -m benchmarks.estimators.misses [--write]     # after python -m benchmarks.estimators
"""

from collections import Counter
from pathlib import Path

import cv2
import numpy as np
import tyro

from benchmarks.estimators.data import FOLDER, SCORED, made
from benchmarks.estimators.score import SETTINGS, place_of
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord, TargetRecord
from warehouse_sim.estimators.registries import trained_names
from warehouse_sim.evaluation import Scores, read_scores
from warehouse_sim.evaluation.report.images import close_up

PICTURE = Path(__file__).parents[2] / "docs" / "images" / "estimator_misses.jpg"
_COLUMNS, _TILE_WH = 7, (272, 170)
_CAPTION_PX = 34
"""Height of the darkened strip under a tile's caption."""
_LIMIT = 0.10
"""ADD in diameters beyond which an object is missed."""
Place = tuple[int, int, int]
"""Scene, image, position among the image's targets."""


def main(folder: Path = FOLDER, setting: str = SETTINGS[-1].name, write: bool = False) -> None:
    """List causes by method and draw every object that a method misses, those that most miss first.

    Args:
        folder: Where data and scores are.
        setting: Which of the settings.
        write: Store the image.
    """
    data = made(SCORED[0], folder)
    reader = DatasetReader(data)
    images = {(image.scene_id, image.image_id): image for image in reader.images("test")}
    missed: dict[Place, list[str]] = {}
    scores: dict[str, Scores] = {}
    chosen = next(item for item in SETTINGS if item.name == setting)
    for method in trained_names():
        place = place_of(folder / "scores" / method / SCORED[0].folder_name, chosen)
        if not place.is_dir():
            continue
        scores[method] = read_scores(place)
        found = _missed(scores[method])
        causes = Counter(cause(*_target(images, key)) for key in found)
        print(f"{method}: {len(found)} of {len(scores[method].table)}: {dict(causes.most_common())}")
        for key in found:
            missed.setdefault(key, []).append(method)
    ranked = sorted(missed, key=lambda key: -len(missed[key]))
    print(
        f"{len(ranked)} objects missed by at least one method, "
        f"{sum(len(methods) == len(scores) for methods in missed.values())} by all"
    )
    tiles = [_tile(reader, images, key, missed[key], scores) for key in ranked]
    if write and tiles:
        tiles += [np.full_like(tiles[0], 255)] * (-len(tiles) % _COLUMNS)
        lines = [np.hstack(tiles[start : start + _COLUMNS]) for start in range(0, len(tiles), _COLUMNS)]
        cv2.imwrite(str(PICTURE), np.vstack(lines)[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 72])
        print(f"output: {PICTURE}")


def cause(image: ImageRecord, target: TargetRecord) -> str:
    """Name what makes a target hard, the most likely first."""
    left, top, right, bottom = target.box_amodal_xyxy
    inside = max(0.0, min(right, image.camera.width - 1) - max(left, 0)) / max(right - left, 1e-9)
    inside *= max(0.0, min(bottom, image.camera.height - 1) - max(top, 0)) / max(bottom - top, 1e-9)
    distance = float(np.linalg.norm(target.T_camera_object[:3, 3]))
    if inside < 0.6:
        return "cut by the border"
    if target.visible_fraction < 0.3:
        return "less than 30 % visible"
    if target.pixels_visible < 400:
        return "fewer than 400 pixels"
    if distance < 2.0:
        return "nearer than 2 m"
    return "none of these"


def _missed(scores: Scores) -> list[Place]:
    table = scores.table
    rows = np.flatnonzero(table.add >= _LIMIT * table.diameter)
    return [(int(table.scene_id[row]), int(table.image_id[row]), int(table.gt_index[row])) for row in rows]


def _target(images: dict[tuple[int, int], ImageRecord], key: Place) -> tuple[ImageRecord, TargetRecord]:
    image = images[key[:2]]
    return image, image.targets[key[2]]


def _tile(
    reader: DatasetReader,
    images: dict[tuple[int, int], ImageRecord],
    key: Place,
    methods: list[str],
    scores: dict[str, Scores],
) -> np.ndarray:
    image, target = _target(images, key)
    table = scores[methods[0]].table
    row = int(np.flatnonzero((table.scene_id == key[0]) & (table.image_id == key[1]) & (table.gt_index == key[2]))[0])
    prediction = int(table.prediction[row])
    estimate = scores[methods[0]].estimates[prediction].T_camera_object if prediction >= 0 else None
    overlay = close_up(reader.rgb(image), image.camera, reader.objects[target.obj_id], target.T_camera_object, estimate)
    tile = cv2.resize(overlay, _TILE_WH, interpolation=cv2.INTER_AREA)
    tile[:_CAPTION_PX] //= 4
    for number, text in enumerate((
        f"{key[0]}/{key[1]}: {target.visible_fraction:.0%} seen, {target.T_camera_object[2, 3]:.1f} m",
        f"{cause(image, target)}; {len(methods)} of {len(scores)} miss it",
    )):  # fmt: skip
        place = (6, 14 + 14 * number)
        cv2.putText(tile, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.38, (255, 255, 255), 1, cv2.LINE_AA)
    return tile


if __name__ == "__main__":
    tyro.cli(main)
