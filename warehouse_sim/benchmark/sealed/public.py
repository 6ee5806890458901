"""The public half of a frozen set: a BOP folder of images, calibration, CAD and lists of targets, and nothing else."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.dataset.formats.bop import BopLayout, BopSceneLayout, bop_layout
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.geometry.pose import Transform, invert
from warehouse_sim.output import make_folder, write_bytes

IMAGES = ("rgb", "depth")
SPLIT = "test"


def write_public(root: Path, out: Path) -> None:
    """Write what a stranger gets of a dataset.

    Args:
        root: The dataset, with its labels.
        out: A new folder; others' readers take it as a BOP dataset.
    """
    reader, private, public = DatasetReader(root), bop_layout(root), BopLayout(out)
    images = reader.images(SPLIT)
    make_folder(out)
    shutil.copyfile(private.camera, public.camera)
    shutil.copyfile(private.targets(2019), public.targets(2019))
    classes = {str(number): info.class_name for number, info in reader.objects.items()}
    names = {str(number): info.name for number, info in reader.objects.items()}
    for file, words in (("classes.json", classes), ("names.json", names)):
        write_bytes(out / file, (json.dumps(words) + "\n").encode("utf-8"))
    for kind in ("models", "models_eval"):
        make_folder(out / kind)
        for path in (private.root / kind).iterdir():
            if path.suffix == ".ply" or path == private.models_info(kind):
                shutil.copyfile(path, out / kind / path.name)
    for scene_id in sorted({image.scene_id for image in images}):
        mine = [image for image in images if image.scene_id == scene_id]
        _write_scene(private.scene(SPLIT, scene_id), public.scene(SPLIT, scene_id), mine)


def _write_scene(private: BopSceneLayout, public: BopSceneLayout, images: list[ImageRecord]) -> None:
    for kind in IMAGES:
        make_folder(public.root / kind)
        for image in images:
            shutil.copyfile(private.image(kind, image.image_id), public.image(kind, image.image_id))
    given = json.loads(private.table("camera").read_text(encoding="utf-8"))
    rows = {str(image.image_id): _camera(given[str(image.image_id)], image) for image in images}
    write_bytes(public.table("camera"), (json.dumps(rows, indent=1) + "\n").encode("utf-8"))


def _camera(given: dict[str, Any], image: ImageRecord) -> dict[str, Any]:
    """Return a row of scene_camera.json: intrinsics, and of the place in the world only tilt and height."""
    T_camera_world = invert(levelled(image.T_world_camera))
    kept = {key: value for key, value in given.items() if not key.endswith("_w2c")}
    return kept | {
        "cam_R_w2c": T_camera_world[:3, :3].ravel().tolist(),
        "cam_t_w2c": (1000.0 * T_camera_world[:3, 3]).tolist(),
    }


def levelled(T_world_camera: Transform) -> Transform:
    """Return the pose of a camera over a world of its own: its origin below it, x where it looks."""
    x, y, _ = T_world_camera[:3, 2]
    length = np.hypot(x, y)
    c, s = (x / length, y / length) if length > 0.0 else (1.0, 0.0)
    T = np.eye(4)
    T[:3, :3] = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) @ T_world_camera[:3, :3]
    T[2, 3] = T_world_camera[2, 3]
    return T
