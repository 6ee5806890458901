"""Pure functions from what was rendered, and the scene behind it, to labels."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from jaxtyping import Bool, Float32, Int

from warehouse_sim.annotate.occluders import box_in_image, hidden_by, kinds_by_id, window_in_image
from warehouse_sim.geometry.camera import PinholeCamera, ViewPyramid
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.schema import ObjectAnnotation, ObjectInstance, RenderBuffers, SceneSpec

__all__ = ["annotate", "targets_in_view"]


def targets_in_view(scene: SceneSpec, camera: PinholeCamera, T_world_camera: Transform) -> list[ObjectInstance]:
    """Return the targets whose bounding sphere reaches into the image, in order of instance id.

    All targets that ``annotate`` would label are among them.
    """
    targets = scene.target_instances()
    origins = np.array([target.T_world_object[:3, 3] for target in targets]).reshape(-1, 3)
    radii = np.array([scene.model_of(target).radius for target in targets])
    seen = ViewPyramid.of(camera).touches(transform_points(invert(T_world_camera), origins), radii)
    return [target for target, is_seen in zip(targets, seen, strict=True) if is_seen]


class PlacedMask(Protocol):
    """An object's unoccluded amodal mask on the pixel grid of the image, as renderers return it."""

    @property
    def offset(self) -> tuple[int, int]:
        """Column and row in the image of the mask's first pixel; may be negative."""

    @property
    def mask(self) -> Bool[np.ndarray, "sh sw"]:
        """The covered pixels, tight."""


def annotate(
    scene: SceneSpec,
    camera: PinholeCamera,
    T_world_camera: Transform,
    buffers: RenderBuffers,
    depth_reading: Float32[np.ndarray, "h w"],
    amodal_masks: Sequence[PlacedMask],
    targets: Sequence[ObjectInstance] | None = None,
    film: Bool[np.ndarray, "h w"] | None = None,
) -> tuple[ObjectAnnotation, ...]:
    """Label every target whose amodal mask touches the image, in order of instance id.

    Args:
        scene: What was rendered.
        camera: With which intrinsics.
        T_world_camera: From where.
        buffers: The clean rendering.
        depth_reading: Depth as the sensor gives it (m), 0 = no reading.
        amodal_masks: One for each of ``targets``, in that order.
        targets: The objects to label, in order of instance id; all targets of the scene when omitted.
        film: Pixels before whose first surface film lies, as ``film_image`` gives them; None where it is not asked.

    Raises:
        ValueError: Not one amodal mask for each target, or images of another size than the camera's.
    """
    targets = scene.target_instances() if targets is None else targets
    if len(amodal_masks) != len(targets):
        raise ValueError(f"{len(targets)} targets need as many amodal masks, found {len(amodal_masks)}")
    for image in (buffers.instance_mask, depth_reading):
        if image.shape != (camera.height, camera.width):
            raise ValueError(f"an image of shape {image.shape} is not {camera.height} rows of {camera.width}")
    T_camera_world, kinds = invert(T_world_camera), kinds_by_id(scene)
    labels = (
        _label(scene, instance, T_camera_world, buffers, depth_reading, amodal_mask, kinds, film)
        for instance, amodal_mask in zip(targets, amodal_masks, strict=True)
    )
    return tuple(label for label in labels if label is not None)


def _label(
    scene: SceneSpec,
    instance: ObjectInstance,
    T_camera_world: Transform,
    buffers: RenderBuffers,
    depth_reading: Float32[np.ndarray, "h w"],
    amodal_mask: PlacedMask,
    kinds: Int[np.ndarray, " n"],
    film: Bool[np.ndarray, "h w"] | None,
) -> ObjectAnnotation | None:
    """Return the label of one target, or None when its amodal mask misses the image."""
    mask = amodal_mask.mask
    height, width = mask.shape
    image_hw = (depth_reading.shape[0], depth_reading.shape[1])
    window = window_in_image(amodal_mask.offset, (height, width), image_hw)
    pixels_in_image = np.count_nonzero(mask[window.mask]) if window is not None else 0
    if window is None or pixels_in_image == 0:
        return None
    visible = buffers.instance_mask[window.image] == instance.instance_id
    model = scene.model_of(instance)
    left, top = amodal_mask.offset
    return ObjectAnnotation(
        instance_id=instance.instance_id,
        class_name=model.class_name,
        obj_id=model.obj_id,
        T_camera_object=T_camera_world @ instance.T_world_object,
        size=model.size,
        box_amodal_xyxy=(float(left), float(top), float(left + width - 1), float(top + height - 1)),
        box_visible_xyxy=box_in_image(visible, window),
        amodal_mask_offset=amodal_mask.offset,
        amodal_mask=mask,
        pixels_all=int(np.count_nonzero(mask)),
        pixels_in_image=int(pixels_in_image),
        pixels_visible=int(np.count_nonzero(visible)),
        pixels_valid=int(np.count_nonzero(visible & (depth_reading[window.image] > 0))),
        hidden_by=hidden_by(kinds, buffers.instance_mask, mask, window, instance.instance_id, film),
    )
