"""VSD: how much of what is seen of a surface lies elsewhere, by depth images of the object in both poses.

The images are those of ``depth_image``, or of any renderer.
"""

from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.evaluation.errors.depth_image import depth_of
from warehouse_sim.evaluation.errors.surface import ErrorModels
from warehouse_sim.evaluation.pairing import Group
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.schema import PoseEstimate

BOP_TAUS = tuple(np.arange(0.05, 0.51, 0.05).round(2).tolist())
"""Misalignment tolerances of the BOP challenge, as fractions of the diameter."""
BOP_DELTA = 0.015
"""Tolerance of visibility of the BOP challenge (m)."""


def vsd(
    depth_estimated: Float[np.ndarray, "h w"],
    depth_gt: Float[np.ndarray, "h w"],
    depth_seen: Float[np.ndarray, "h w"],
    camera: PinholeCamera,
    diameter: float,
    taus: Sequence[float] = BOP_TAUS,
    delta: float = BOP_DELTA,
) -> Float[np.ndarray, " t"]:
    """Return the visible surface discrepancy (0-1) for each tolerance.

    Hodan et al., BOP (ECCV 2018), equation 2, with the visibility of the challenges since 2019: where the sensor reads
    nothing, the object is taken for visible. Distances are along the ray, not along z.

    Args:
        depth_estimated: The object alone in the estimated pose (m along z, 0 = none).
        depth_gt: The object alone in the true pose.
        depth_seen: What the sensor read.
        camera: Of the images; its lens does not count.
        diameter: Of the object (m).
        taus: Tolerances as fractions of the diameter.
        delta: How far behind the reading a surface counts as visible (m).
    """
    rays = _ray_lengths(camera)
    estimated, true, seen = rays * depth_estimated, rays * depth_gt, rays * depth_seen
    # In 32 bits, as the public reference compares them: pixels at the very limit would fall to the other side.
    visible_gt = _in_view(true, seen, delta)
    visible_estimated = _in_view(estimated, seen, delta) | (visible_gt & (estimated > 0.0))
    both, either = visible_gt & visible_estimated, int((visible_gt | visible_estimated).sum())
    if either == 0:
        return np.ones(len(taus))
    apart = np.abs(true[both] - estimated[both]) / diameter
    wrong = np.array([(apart >= tau).sum() for tau in taus])
    return (wrong + either - len(apart)) / either


SeenDepth = Callable[[ImageRecord], Float[np.ndarray, "h w"]]
"""Reads what the depth sensor read of an image (m along z, 0 = no reading)."""


def vsd_errors(
    groups: Sequence[Group], predictions: Sequence[PoseEstimate], models: ErrorModels, seen: SeenDepth
) -> list[Float[np.ndarray, "p g t"]]:
    """Return by group the discrepancy of each estimate against each ground truth, at each tolerance.

    Args:
        groups: What can belong together; objects must have CAD.
        predictions: Estimates of all images.
        models: Where surfaces come from.
        seen: Reads depth images.
    """
    errors, last = [], None
    for group in groups:
        found = np.ones((len(group.estimates), len(group.targets), len(BOP_TAUS)))
        errors.append(found)
        if not group.estimates:
            continue
        if last is None or last[0] is not group.image:
            last = group.image, seen(group.image)
        camera, info = group.image.camera, models.info(group.targets[0])
        mesh = info.mesh()
        true = [depth_of(mesh, target.T_camera_object, camera) for target in group.targets]
        for row, index in enumerate(group.estimates):
            estimated = depth_of(mesh, predictions[index].T_camera_object, camera)
            for column, image in enumerate(true):
                # Surfaces that share no pixel differ in all of them.
                if (estimated.astype(bool) & image.astype(bool)).any():
                    found[row, column] = vsd(estimated, image, last[1], camera, info.diameter)
    return errors


def _in_view(
    distance: Float[np.ndarray, "h w"], seen: Float[np.ndarray, "h w"], delta: float
) -> Float[np.ndarray, "h w"]:
    behind = distance.astype(np.float32) - seen.astype(np.float32)
    return ((behind <= delta) | (seen == 0.0)) & (distance > 0.0)


def _ray_lengths(camera: PinholeCamera) -> Float[np.ndarray, "h w"]:
    """Return the length of the ray to z = 1 of each pixel."""
    x = (np.arange(camera.width) - camera.cx) / camera.fx
    y = (np.arange(camera.height) - camera.cy) / camera.fy
    return np.sqrt(1.0 + x[None] ** 2 + y[:, None] ** 2)
