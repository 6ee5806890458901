"""The scene behind stored images, as far as a dataset tells it: what stands where, and the geometry of its targets."""

from collections.abc import Mapping

import numpy as np

from warehouse_sim.dataset.convert.stored_observation import instance_id
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.dataset.scene_record import RecordedObject, SceneRecord
from warehouse_sim.schema import ObjectInstance, ObjectModel, Part, SceneSpec

_NO_SIZE = np.zeros(3)


def stored_model(info: ObjectInfo) -> ObjectModel:
    """Return an object's geometry in one part, with the even mesh that it is measured by; none where it has no mesh."""
    has_mesh = info.has_cad and info.read_mesh is not None
    part = (Part(info.mesh(), np.ones(3), np.eye(4), material=""),) if has_mesh else ()
    return ObjectModel(
        name=info.name,
        class_name=info.class_name,
        obj_id=info.obj_id,
        size=info.size,
        parts=part,
        collision=(),
        symmetry=info.symmetry,
        pockets=info.pockets,
        metric_mesh=info.metric_mesh() if has_mesh else None,
    )


def recorded_scene(record: SceneRecord, targets: tuple[str, ...], models: Mapping[int, ObjectModel]) -> SceneSpec:
    """Return the scene of a record; what is no target has a name and a class, and no shape.

    Args:
        record: What is stored of the scene.
        targets: Class names whose objects have labels.
        models: Geometry of the targets by obj_id.
    """
    return SceneSpec(
        scene_index=record.scene_index,
        seed=record.seed,
        models={item.model: models.get(item.obj_id) or _shapeless(item) for item in record.objects},
        materials={},
        instances=tuple(
            ObjectInstance(item.instance_id, item.model, item.T_world_object, group=item.group, paint=item.paint)
            for item in record.objects
        ),
        lights=(),
        viewpoints=(),
        targets=targets,
        settled=True,
    )


def scene_of_image(image: ImageRecord, scene_index: int, models: Mapping[int, ObjectModel]) -> SceneSpec:
    """Return the scene of a single image: its targets, where they are in the camera's world."""
    found = {models[target.obj_id].name: models[target.obj_id] for target in image.targets}
    return SceneSpec(
        scene_index=scene_index,
        seed=0,
        models=found,
        materials={},
        instances=tuple(
            ObjectInstance(
                instance_id(target), models[target.obj_id].name, image.T_world_camera @ target.T_camera_object
            )
            for target in sorted(image.targets, key=instance_id)
            if target.has_pose
        ),
        lights=(),
        viewpoints=(),
        targets=tuple(sorted({model.class_name for model in models.values()})),
        settled=True,
    )


def _shapeless(item: RecordedObject) -> ObjectModel:
    return ObjectModel(item.model, item.class_name, item.obj_id, _NO_SIZE, parts=(), collision=())
