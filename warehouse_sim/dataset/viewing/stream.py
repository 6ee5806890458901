"""Rerun shows images in time, labels, sweep, rig and way with them: what is streamed, and to which file or viewer."""

import json
import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.dataset.stored.scene_record import SceneRecord, read_scene_record
from warehouse_sim.dataset.viewing.overlay import colorize_instances
from warehouse_sim.dataset.viewing.screen import require_screen
from warehouse_sim.errors import InputError
from warehouse_sim.geometry.pose import Transform, invert, quat_wxyz_from_matrix
from warehouse_sim.optional import require
from warehouse_sim.output import make_folder, partial_file, writing

_RIG = "world/rig"
_CAMERA = f"{_RIG}/camera"
_IMAGE = f"{_CAMERA}/image"
_LIDAR = f"{_CAMERA}/lidar"
CountProgress = Callable[[int, int], None]


def stream_images(
    reader: DatasetReader,
    images: Sequence[ImageRecord],
    recording: Any,
    progress: CountProgress = lambda done, total: None,
) -> None:
    """Log images in order; their timelines are ``observation``, ``scene`` and, where it is known, ``time``.

    Args:
        reader: The dataset.
        images: Which of its images, those of a scene one after the other.
        recording: Stream of Rerun.
        progress: Called with how many are done, and how many there are.

    Raises:
        DatasetError: A file of the dataset is missing or malformed.
    """
    rerun = require("rerun", "view", "to view a dataset")
    recording.log("world", rerun.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    record: SceneRecord | None = None
    scene = None
    for done, image in enumerate(images):
        if image.scene_id != scene:
            scene = image.scene_id
            record = None if reader.manifest is None else read_scene_record(reader.root, scene, objects=False)
        recording.set_time("observation", sequence=done)
        recording.set_time("scene", sequence=image.scene_id)
        _log_rig(rerun, recording, image, record)
        _log_way(rerun, recording, [item for item in images[: done + 1] if item.scene_id == scene])
        _log_camera(rerun, recording, reader, image)
        _log_exact(rerun, recording, reader, image)
        _log_targets(rerun, recording, reader, image)
        _log_sweep(rerun, recording, reader, image)
        progress(done + 1, len(images))


def _log_rig(rerun: Any, recording: Any, image: ImageRecord, record: SceneRecord | None) -> None:
    """Log where vehicle and camera are, and under which conditions the image was taken."""
    T_world_rig = image.T_world_camera
    if record is not None and image.image_id < len(record.observations):
        seen = record.observations[image.image_id]
        recording.set_time("time", duration=seen.time)
        T_world_rig = T_world_rig if seen.T_world_vehicle is None else seen.T_world_vehicle
        words = ", ".join(f"{name}={value}" for name, value in vars(seen.conditions).items() if value not in (None, ""))
        recording.log("conditions", rerun.TextLog(words, level="INFO"))
    recording.log(_RIG, _placed(rerun, T_world_rig), rerun.TransformAxes3D(0.5))
    recording.log(_CAMERA, _placed(rerun, invert(T_world_rig) @ image.T_world_camera))


def _log_way(rerun: Any, recording: Any, so_far: Sequence[ImageRecord]) -> None:
    """Log where the camera was in this scene."""
    places = np.array([item.T_world_camera[:3, 3] for item in so_far])
    recording.log("world/way", rerun.LineStrips3D([places], colors=[255, 200, 0], radii=0.01))
    recording.log("world/way/stops", rerun.Points3D(places, colors=[255, 200, 0], radii=0.03))


def _log_camera(rerun: Any, recording: Any, reader: DatasetReader, image: ImageRecord) -> None:
    """Log colour and depth as far as the dataset holds them.

    Rerun counts pixels from the outer corner of the first, so that the axis moves by half.
    """
    camera = image.camera
    rgb = None if reader.leaves_out("rgb") else reader.rgb(image)
    depth = None if reader.leaves_out("depth") else reader.depth(image)
    pinhole = rerun.Pinhole(
        focal_length=[camera.fx, camera.fy],
        principal_point=[camera.cx + 0.5, camera.cy + 0.5],
        resolution=[camera.width, camera.height],
        camera_xyz=rerun.ViewCoordinates.RDF,
        image_plane_distance=0.5,
    )
    recording.log(_IMAGE, pinhole, *([] if rgb is None else [rerun.Image(rgb)]))
    if depth is None:
        return
    if camera.distortion is None:
        recording.log(f"{_IMAGE}/depth", rerun.DepthImage(depth, meter=1.0))
        return
    # Rerun has no lenses: behind one, points go where they are, and the depth image stands for itself.
    seen = depth > 0
    points = camera.unproject(depth)[seen].astype(np.float32)
    recording.log("depth", rerun.DepthImage(depth, meter=1.0))
    colors = None if rgb is None else rgb[seen]
    recording.log(f"{_CAMERA}/points", rerun.Points3D(points, colors=colors, radii=0.003))


def _log_exact(rerun: Any, recording: Any, reader: DatasetReader, image: ImageRecord) -> None:
    """Log images of exact data that the dataset holds: directions and places as colours, classes by their names."""
    made = () if reader.manifest is None else reader.manifest.contents.codings
    if "normals" in made:
        normals = reader.normals(image)
        colors = np.where(normals.any(axis=2, keepdims=True), 127.5 + 127.5 * normals, 0.0)
        recording.log(f"{_IMAGE}/normals", rerun.Image(np.rint(colors).astype(np.uint8)))
    if "object_coordinates" in made:
        places = np.nan_to_num(reader.object_coordinates(image), nan=0.0)
        recording.log(f"{_IMAGE}/object_coordinates", rerun.Image(np.rint(255.0 * places).astype(np.uint8)))
    if "class_mask" in made:
        names = reader.mask_classes(image)
        colors = colorize_instances(np.array(list(names), np.int64))
        entries = [(value, name, color) for (value, name), color in zip(names.items(), colors.tolist(), strict=True)]
        recording.log(f"{_IMAGE}/class_mask", rerun.AnnotationContext(entries))
        recording.log(f"{_IMAGE}/class_mask", rerun.SegmentationImage(reader.class_mask(image)))


def _log_targets(rerun: Any, recording: Any, reader: DatasetReader, image: ImageRecord) -> None:
    """Log boxes and, if any, masks of the labelled targets, in colours and under names that stay with the object."""
    targets, infos = image.targets, [target.info(reader.objects) for target in image.targets]
    numbers = [_number(target) for target in targets]
    if not reader.leaves_out("masks"):
        ids = np.zeros((image.camera.height, image.camera.width), np.uint16)
        for target, number in zip(targets, numbers, strict=True):
            ids[reader.mask_visible(image, target.gt_index)] = number
        recording.log(f"{_IMAGE}/masks", rerun.SegmentationImage(ids, opacity=0.4))
    colors = colorize_instances(np.array(numbers, np.int64))
    labels = [f"{info.class_name} {number}" for info, number in zip(infos, numbers, strict=True)]
    boxes = np.array([target.box_visible_xyxy for target in targets], float).reshape(-1, 4) + np.array([0, 0, 1, 1])
    recording.log(
        f"{_IMAGE}/boxes",
        rerun.Boxes2D(array=boxes, array_format=rerun.Box2DFormat.XYXY, colors=colors, labels=labels),
    )
    solid = rerun.Boxes3D(
        centers=np.array([target.T_camera_object[:3, 3] for target in targets]).reshape(-1, 3),
        sizes=np.array([info.size for info in infos]).reshape(-1, 3),
        quaternions=[_quaternion(rerun, target.T_camera_object) for target in targets],
        colors=colors,
        labels=labels,
    )
    recording.log(f"{_CAMERA}/boxes", solid)


def _log_sweep(rerun: Any, recording: Any, reader: DatasetReader, image: ImageRecord) -> None:
    """Log the main LiDAR's points in the colours of their ids, grey where they are of nothing."""
    sweep = reader.sweep(image)
    if sweep is None:
        return
    ids = np.maximum(sweep.reading.instance_ids, 0)
    colors = np.where((ids == 0)[:, None], np.uint8(128), colorize_instances(ids))
    recording.log(_LIDAR, _placed(rerun, sweep.T_camera_sensor))
    recording.log(f"{_LIDAR}/points", rerun.Points3D(sweep.reading.points, colors=colors, radii=0.01))


def _number(target: TargetRecord) -> int:
    """Return the object's number in its scene, or else its place among the image's labels."""
    return target.instance_id or target.gt_index + 1


def _placed(rerun: Any, T_parent_child: Transform) -> Any:
    return rerun.Transform3D(translation=T_parent_child[:3, 3], mat3x3=T_parent_child[:3, :3])


def _quaternion(rerun: Any, T: Transform) -> Any:
    w, x, y, z = quat_wxyz_from_matrix(T[:3, :3])
    return rerun.Quaternion(xyzw=[x, y, z, w])


_APPLICATION = "warehouse_sim"
_PORT = 9876
_SETTINGS = "XDG_CONFIG_HOME"
_REMEDY = (
    "write a page with --html FILE.html or serve one with --web, "
    "or write --save FILE.rrd and open it with 'rerun FILE.rrd' where there is one"
)


@contextmanager
def open_recording(name: str, save: Path | None, port: int = _PORT) -> Iterator[Any]:
    """Yield a stream of Rerun that goes to a file or to a viewer, which is started.

    A file gets its name when all is in it. A viewer listens on the loopback address.

    Args:
        name: Of the recording: the same dataset has the same one.
        save: File to write (.rrd); None = a viewer.
        port: Where a viewer listens, on the loopback address.

    Raises:
        MissingPackageError: Rerun is not installed.
        InputError: There is no screen, or no viewer could be started.
        OutputError: The file cannot be written.
    """
    rerun = require("rerun", "view", "to view a dataset")
    recording = rerun.RecordingStream(_APPLICATION, recording_id=name, send_properties=False)
    # When something was streamed says nothing of it.
    rerun.set_log_time_enabled(False, recording=recording)
    rerun.set_log_tick_enabled(False, recording=recording)
    if save is None:
        with _silent_viewer():
            _spawn(recording, port)
            yield recording
            recording.flush()
            recording.disconnect()
        return
    make_folder(save.parent)
    partial = partial_file(save)
    with writing(save):
        partial.touch()
    try:
        recording.save(partial)
        yield recording
        recording.flush()
        recording.disconnect()
    except BaseException:
        recording.disconnect()
        partial.unlink(missing_ok=True)
        raise
    with writing(save):
        os.replace(partial, save)


@contextmanager
def _silent_viewer() -> Iterator[None]:
    """Let viewers that are started meanwhile send no statistics of their use to their makers.

    They read so in a folder of settings that is theirs alone; those of the user stay as they are.
    """
    before = os.environ.get(_SETTINGS)
    with tempfile.TemporaryDirectory(prefix="warehouse_sim-") as folder:
        path = Path(folder) / "rerun" / "analytics.json"
        path.parent.mkdir()
        silent = {"analytics_enabled": False, "analytics_id": "", "metadata": {}}
        data = str(path.parent)
        path.write_text(json.dumps(silent | {"config_file_path": str(path), "data_dir_path": data}))
        os.environ[_SETTINGS] = folder
        try:
            yield
        finally:
            if before is None:
                del os.environ[_SETTINGS]
            else:
                os.environ[_SETTINGS] = before


def _spawn(recording: Any, port: int) -> None:
    """Start a viewer.

    Raises:
        InputError: It cannot show anything here.
    """
    require_screen("the Rerun viewer", _REMEDY)
    try:
        recording.spawn(port=port, hide_welcome_screen=True)
    except RuntimeError as problem:
        reason = " ".join(str(problem).split())[:200]
        raise InputError(f"the Rerun viewer could not be started ({reason}); {_REMEDY}") from problem
