"""Which targets are worth an amodal mask: those that can touch the image."""

import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.geometry.view_pyramid import ViewPyramid
from warehouse_sim.schema import ObjectInstance, ObjectModel, SceneSpec


def targets_in_view(scene: SceneSpec, camera: PinholeCamera, T_world_camera: Transform) -> list[ObjectInstance]:
    """Return the targets whose bounding sphere reaches into the image, in order of instance id.

    All targets that ``annotate`` would label are among them.
    """
    targets = scene.target_instances()
    radius_of = {name: _radius(scene.models[name]) for name in {target.model for target in targets}}
    origins = np.array([target.T_world_object[:3, 3] for target in targets]).reshape(-1, 3)
    radii = np.array([radius_of[target.model] for target in targets])
    seen = ViewPyramid.of(camera).touches(transform_points(invert(T_world_camera), origins), radii)
    return [target for target, is_seen in zip(targets, seen, strict=True) if is_seen]


def _radius(model: ObjectModel) -> float:
    """Return the distance (m) of the farthest vertex from the model's origin."""
    return max(float(np.linalg.norm(part.placed().vertices, axis=1).max()) for part in model.parts)
