"""What a dataset has stored, as the scenes and observations that writers take."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Bool, Int32

from warehouse_sim.dataset.formats.observation_files import ObservationFiles
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.dataset.stored.observation_record import OF_VIEWPOINT, RecordedObservation, RecordedTarget
from warehouse_sim.dataset.stored.scene_record import RecordedObject, SceneRecord
from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.schema import (
    CAMERA,
    LIDAR,
    NO_COLOR,
    Conditions,
    LidarScan,
    MountedReading,
    ObjectAnnotation,
    ObjectInstance,
    ObjectModel,
    Observation,
    Part,
    Reading,
    RenderBuffers,
    RgbdReading,
    SceneSpec,
    Viewpoint,
)


def stored_observation(
    reader: DatasetReader, image: ImageRecord, number: tuple[int, int], recorded: RecordedObservation | None = None
) -> ObservationFiles:
    """Read all that a dataset holds of one image.

    What no file holds is missing: ids of pixels that are no target's are 0, amodal masks end at the image's border, and
    without clean images the readings stand for them. What was left out is empty; boxes and counts are then the label's.

    Args:
        reader: The dataset.
        image: Which image.
        number: Scene and observation that it becomes.
        recorded: What the scene record says of it; None where there is none.
    """
    shape = (image.camera.height, image.camera.width)
    rgb = NO_COLOR if reader.leaves_out("rgb") else reader.rgb(image)
    depth = np.zeros(shape, np.float32) if reader.leaves_out("depth") else reader.depth(image)
    readings: dict[str, MountedReading[Reading]] = {CAMERA: MountedReading(np.eye(4), RgbdReading(rgb, depth))}
    sweep = reader.sweep(image)
    if sweep is not None:
        scan = sweep.reading if recorded is not None else _of_targets(sweep.reading, image)
        readings[LIDAR] = MountedReading(sweep.T_camera_sensor, scan)
    for name, item in reader.readings(image).items():
        readings[name] = MountedReading(item.T_camera_sensor, item.reading)
    instance_mask = np.zeros(shape, dtype=np.int32)
    annotations = [_annotation(reader, image, target, depth > 0, instance_mask) for target in _far_to_near(image)]
    measured = {} if recorded is None else {target.instance_id: target for target in recorded.targets}
    observation = Observation(
        *number,
        camera=image.camera,
        # The record has every digit; formats store the inverse, or millimetres.
        T_world_camera=image.T_world_camera if recorded is None else recorded.T_world_camera,
        readings=readings,
        buffers=RenderBuffers(
            reader.clean_rgb(image) if reader.has_clean else rgb,
            reader.clean_depth(image) if reader.has_clean else depth,
            instance_mask,
        ),
        annotations=tuple(
            _measured(item, measured.get(item.instance_id))
            for item in sorted(annotations, key=lambda item: item.instance_id)
        ),
        viewpoint=None if recorded is None else _viewpoint(recorded),
        conditions=Conditions() if recorded is None else recorded.conditions,
        nominal=None if recorded is None else recorded.nominal,
    )
    return ObservationFiles(observation, reader.rgb_file(image))


def _of_targets(scan: LidarScan, image: ImageRecord) -> LidarScan:
    """Return a sweep whose points have no other ids than those of the image's targets: nothing else is known."""
    known = np.isin(scan.instance_ids, [instance_id(target) for target in image.targets])
    return replace(scan, instance_ids=np.where(known, scan.instance_ids, 0).astype(scan.instance_ids.dtype))


def instance_id(target: TargetRecord) -> int:
    """Return a target's number in its scene; where the dataset has none, that of its label."""
    return target.instance_id or target.gt_index + 1


def _far_to_near(image: ImageRecord) -> list[TargetRecord]:
    """Return the targets in the order in which their pixels are painted: boxes that stand for masks overlap."""
    return sorted(image.targets, key=lambda item: -float(item.T_camera_object[2, 3]) if item.has_pose else 0.0)


def _annotation(
    reader: DatasetReader,
    image: ImageRecord,
    target: TargetRecord,
    has_depth: Bool[np.ndarray, "h w"],
    instance_mask: Int32[np.ndarray, "h w"],
) -> ObjectAnnotation:
    """Return a target's label and paint its visible pixels into ``instance_mask``."""
    nothing, stored = np.zeros_like(has_depth), not reader.leaves_out("masks")
    visible = reader.mask_visible(image, target.gt_index) if stored else nothing
    whole = nothing if reader.leaves_out("amodal_masks") else reader.mask(image, target.gt_index)
    instance_mask[visible] = instance_id(target)
    whole = whole | visible  # others round the two masks in different ways
    box = mask_box_xyxy(whole)
    left, top, right, bottom = (0, 0, -1, -1) if box is None else box
    info = target.info(reader.objects)
    inside = int(np.count_nonzero(whole))
    return ObjectAnnotation(
        instance_id=instance_id(target),
        class_name=info.class_name,
        obj_id=target.obj_id,
        T_camera_object=target.T_camera_object,
        size=info.size,
        box_amodal_xyxy=target.box_amodal_xyxy,
        box_visible_xyxy=mask_box_xyxy(visible) if stored else _whole_box(target),
        amodal_mask_offset=(left, top),
        amodal_mask=whole[top : bottom + 1, left : right + 1],
        pixels_all=max(target.pixels_all, inside),
        pixels_in_image=inside,
        pixels_visible=int(np.count_nonzero(visible)) if stored else target.pixels_visible,
        pixels_valid=int(np.count_nonzero(visible & has_depth)),
    )


def _whole_box(target: TargetRecord) -> tuple[int, int, int, int]:
    left, top, right, bottom = map(round, target.box_visible_xyxy)
    return left, top, right, bottom


def _measured(annotation: ObjectAnnotation, recorded: RecordedTarget | None) -> ObjectAnnotation:
    if recorded is None:
        return annotation
    return replace(annotation, hidden_by=recorded.hidden_by, illuminance=recorded.illuminance)


def _viewpoint(recorded: RecordedObservation) -> Viewpoint:
    told: dict[str, Any] = {name: getattr(recorded, name) for name in OF_VIEWPOINT}
    return Viewpoint(T_world_camera=recorded.T_world_camera, **told)


_NO_SIZE = np.zeros(3)


def stored_model(info: ObjectInfo) -> ObjectModel:
    """Return an object's geometry in one part, with the even mesh that it is measured by; none where it has no mesh."""
    part = (Part(info.mesh(), np.ones(3), np.eye(4), material=""),) if info.has_mesh else ()
    return ObjectModel(
        name=info.name,
        class_name=info.class_name,
        obj_id=info.obj_id,
        size=info.size,
        parts=part,
        collision=(),
        symmetry=info.symmetry,
        pockets=info.pockets,
        metric_mesh=info.metric_mesh() if info.has_mesh else None,
    )


def recorded_scene(record: SceneRecord, targets: tuple[str, ...], models: Mapping[int, ObjectModel]) -> SceneSpec:
    """Return the scene of a record; what is no target has a name and a class, and no shape.

    Args:
        record: What is stored of the scene.
        targets: Class names whose objects have labels.
        models: Geometry of the targets by obj_id.
    """
    instances = tuple(
        ObjectInstance(item.instance_id, item.model, item.T_world_object, group=item.group, paint=item.paint)
        for item in record.objects
    )
    found = {item.model: models.get(item.obj_id) or _shapeless(item) for item in record.objects}
    return _scene(record.scene_index, record.seed, found, instances, targets)


def scene_of_image(image: ImageRecord, scene_index: int, models: Mapping[int, ObjectModel]) -> SceneSpec:
    """Return the scene of a single image: its targets, where they are in the camera's world."""
    found = {models[target.obj_id].name: models[target.obj_id] for target in image.targets}
    instances = tuple(
        ObjectInstance(instance_id(target), models[target.obj_id].name, image.T_world_camera @ target.T_camera_object)
        for target in sorted(image.targets, key=instance_id)
        if target.has_pose
    )
    classes = sorted({model.class_name for model in models.values()})
    return _scene(scene_index, 0, found, instances, tuple(classes))


def _scene(
    index: int,
    seed: int,
    models: dict[str, ObjectModel],
    instances: tuple[ObjectInstance, ...],
    targets: tuple[str, ...],
) -> SceneSpec:
    """Return a settled scene of which nothing is known but what stands in it."""
    return SceneSpec(index, seed, models, {}, instances, lights=(), viewpoints=(), targets=targets, settled=True)


def _shapeless(item: RecordedObject) -> ObjectModel:
    return ObjectModel(item.model, item.class_name, item.obj_id, _NO_SIZE, parts=(), collision=())
