"""Whether estimators dock at recorded pallet fronts that are in no catalog, as they are and with gravity given.

    python -m benchmarks.estimators.fronts FOLDER front-fit --write

FOLDER holds sites with labels.json, depth and masks, as the real samples beside this project have them; nothing of it
is copied. An estimator that answers with a front is taken at its word; one that answers with the pose of a catalog
pallet, which --catalog and --model name, sends the fork to that pallet's pockets.
"""

from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path

import cv2
import numpy as np
import tyro

from benchmarks.estimators.plane_and_rectangle import dock_of
from benchmarks.estimators.recorded_fronts import Entry, RecordedFront, drive_in, read_fronts
from benchmarks.estimators.ways import open_way
from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators import PoseEstimator
from warehouse_sim.estimators.rgbd_image import Detection, RgbdImage
from warehouse_sim.evaluation.docking import ForkConfig, approached_face, docking_faces
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.schema import PoseEstimate

TRIVIAL = "plane and rectangle"
GRAVITY = ("none", "label", "label, 0.3 deg off")
MASKS = ("label", "dilated by 5 px", "box")
_OFF_DEG = 0.3


def masked(mask: np.ndarray, kind: str, model: str | None) -> Detection:
    """Return a detection by a mask, by one that is 5 px too wide all round, or by its box."""
    if kind == "box":
        v, u = np.nonzero(mask)
        return Detection(None, model, box_xyxy=(float(u.min()), float(v.min()), float(u.max()), float(v.max())))
    if kind == "dilated by 5 px":
        mask = cv2.dilate(mask.astype(np.uint8), np.ones((11, 11), np.uint8)) > 0
    return Detection(mask, model)


def gravity_of(front: RecordedFront, kind: str, rng: np.random.Generator) -> np.ndarray | None:
    """Return what is told of gravity."""
    if kind == "none":
        return None
    if kind == "label":
        return front.gravity
    axis = np.cross(front.gravity, rng.normal(size=3))
    off = front.gravity + np.tan(np.deg2rad(_OFF_DEG)) * np.cross(axis / np.linalg.norm(axis), front.gravity)
    return np.asarray(off / np.linalg.norm(off))


Answer = tuple[Transform, list[np.ndarray] | None]
"""A dock frame, and where its pockets are on it."""


def answer_of(estimate: PoseEstimate, objects: dict[int, ObjectInfo]) -> Answer | None:
    """Return where an estimate sends the fork; None where it does not say."""
    if estimate.front is not None:
        return estimate.front.T_camera_dock, list(estimate.front.pockets)
    info = objects.get(estimate.obj_id)
    if info is None or not info.pockets:
        return None
    faces = docking_faces(info.size, info.pockets)
    face = faces[int(approached_face(estimate.T_camera_object[None], faces)[0])]
    inside = [transform_points(invert(face.T_object_dock), p.T_object_pocket[None, :3, 3])[0, 1:] for p in face.pockets]
    return estimate.T_camera_object @ face.T_object_dock, inside


def estimated(
    estimator: PoseEstimator | None, objects: dict[int, ObjectInfo], image: RgbdImage, color: Path
) -> Answer | None:
    """Return where an estimator, or for None the trivial method, sends the fork."""
    if estimator is None:
        pixels = image.detections[0].pixels(*image.depth.shape) & (image.depth > 0)
        points = image.camera.unproject(image.depth)[pixels].astype(float)
        return dock_of(points, image.gravity, np.random.default_rng(0)), None
    if getattr(estimator, "reads_rgb", True):
        image = replace(image, rgb=cv2.cvtColor(cv2.imread(str(color)), cv2.COLOR_BGR2RGB))
    found = estimator.estimate(image)
    return answer_of(found[0], objects) if found else None


def entries(
    estimator: PoseEstimator | None,
    objects: dict[int, ObjectInfo],
    fronts: Sequence[RecordedFront],
    masks: str,
    gravity: str,
    model: str | None = None,
) -> list[Entry | None]:
    """Return what the fork does at each front; None where there is no answer."""
    found: list[Entry | None] = []
    for index, front in enumerate(fronts):
        down = gravity_of(front, gravity, np.random.default_rng([7, index]))
        image = RgbdImage.from_arrays(front.depth, front.K, [masked(front.mask, masks, model)], gravity=down)
        answer = estimated(estimator, objects, image, front.color)
        found.append(None if answer is None else drive_in(front, *answer, ForkConfig()))
    return found


def main(
    folder: tyro.conf.Positional[Path],
    methods: tyro.conf.Positional[tuple[str, ...]],
    catalog: Path | None = None,
    model: str | None = None,
    verbose: bool = False,
    write: bool = False,
) -> None:
    """Score estimators on a folder of recorded fronts.

    Args:
        folder: Sites with labels.
        methods: Bundled models or run folders, perhaps with +evidence, or registered estimators; the trivial method is
            added.
        catalog: Dataset folder whose objects estimators are shown; none by default.
        model: Which of them the fronts are said to be of; unknown by default.
        verbose: Print each frame.
        write: Store the result.
    """
    fronts, rows = read_fronts(folder), []
    objects = dict(DatasetReader(catalog).objects) if catalog else {}
    for method in (TRIVIAL, *methods):
        estimator = None if method == TRIVIAL else open_way(method, objects)
        for masks in MASKS:
            for gravity in GRAVITY:
                found = entries(estimator, objects, fronts, masks, gravity, None if estimator is None else model)
                docked = sum(item is not None and item.docked for item in found)
                name = f"{method}, masks: {masks}, gravity: {gravity}"
                print(f"{name:70} {docked:3} of {len(fronts)}", flush=True)
                rows.append(_row(name, method, masks, gravity, fronts, found))
                if verbose:
                    _print(fronts, found)
    if write:
        command = f"python -m benchmarks.estimators.fronts FOLDER {' '.join(methods)} --write"
        how = "recorded fronts of pallets with labels by hand, which are no part of this project"
        write_result(RESULTS / "fronts.json", command, rows, data=how)


def _row(
    name: str, method: str, masks: str, gravity: str, fronts: Sequence[RecordedFront], found: Sequence[Entry | None]
) -> dict:
    frames = {
        front.name: None if item is None else rounded({key: float(value) for key, value in asdict(item).items()})
        for front, item in zip(fronts, found, strict=True)
    }
    docked = sum(item is not None and item.docked for item in found)
    common = {"method": method, "masks": masks, "gravity": gravity}
    return {"name": name, **common, "value": int(docked), "n": len(fronts), "frames": frames}


def _print(fronts: Sequence[RecordedFront], found: Sequence[Entry | None]) -> None:
    for front, item in zip(fronts, found, strict=True):
        if item is None:
            print(f"  {front.name:24} no answer")
            continue
        print(
            f"  {front.name:24} {'docks' if item.docked else 'FAILS'} room {1e3 * item.room_side:5.0f} "
            f"{1e3 * item.room_up:4.0f} mm  depth {1e3 * item.depth:4.0f} lateral {1e3 * item.lateral:4.0f} "
            f"vertical {1e3 * item.vertical:4.0f} mm  yaw {item.yaw_deg:5.2f} pitch {item.pitch_deg:5.2f} "
            f"roll {item.roll_deg:5.2f} deg"
        )


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
