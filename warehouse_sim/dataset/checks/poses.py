"""The check that matters most: the CAD model at the stored pose lands on the stored mask and depth."""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float, Float32, Int

from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.dataset.stored.scene_record import read_damaged_mesh
from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transform, transform_points
from warehouse_sim.schema.outputs import Output

_NEAR = 0.05
_ALONG_EDGE, _SAG_PX = 17, 3.0
"""Points on an edge behind a lens, and by how much the curve between two of them may bulge."""


def mesh_depth(
    mesh: TriangleMesh, T_camera_object: Transform, camera: PinholeCamera
) -> Float[np.ndarray, "h w"] | None:
    """Return the z-depth (m) of a closed mesh at every pixel centre, infinity where it is not; None if it is too near.

    Each triangle covers the pixels inside its three edges; 1/z is linear over the image (Pineda 1988; perspective
    correction as in Blinn 1992). Behind a lens this holds on the pinhole's image, where each pixel then has its place.

    Args:
        mesh: Surface in the object frame (m).
        T_camera_object: Its pose.
        camera: Pixel centres at integers.
    """
    points = transform_points(T_camera_object, mesh.vertices)
    depth = np.full((camera.height, camera.width), np.inf)
    if points[:, 2].min() < _NEAR:
        return None
    if camera.distortion is not None:
        _render_through_lens(depth, points, mesh.faces, camera)
        return depth
    uv = camera.project(points)[mesh.faces]
    places = np.arange(camera.width)[None, :], np.arange(camera.height)[:, None]
    _draw(depth, uv, 1.0 / points[mesh.faces, 2], (uv.min(axis=1), uv.max(axis=1)), places)
    return depth


def _render_through_lens(
    depth: Float[np.ndarray, "h w"],
    points: Float[np.ndarray, "n 3"],
    faces: Int[np.ndarray, "m 3"],
    camera: PinholeCamera,
) -> None:
    """Draw triangles where the lens shows them: straight in the pinhole's image, looked at where the pixels look."""
    pinhole = camera.pinhole
    u, v = np.moveaxis(pinhole.project(camera.rays()), -1, 0)
    # The outline of a face in the image is curved: its ends do not bound it, points along it do, nearly.
    fraction = np.linspace(0.0, 1.0, _ALONG_EDGE)[:, None, None, None]
    corners = np.concatenate([points[:, :2] / points[:, 2:], np.ones((len(points), 1))], axis=1)[faces]
    shown = camera.project(corners + fraction * (np.roll(corners, -1, axis=1) - corners))
    bounds = shown.min(axis=(0, 2)) - _SAG_PX, shown.max(axis=(0, 2)) + _SAG_PX
    _draw(depth, pinhole.project(points)[faces], 1.0 / points[faces, 2], bounds, (u, v))


def _draw(
    depth: Float[np.ndarray, "h w"],
    uv: Float[np.ndarray, "m 3 2"],
    inverse_z: Float[np.ndarray, "m 3"],
    bounds: tuple[Float[np.ndarray, "m 2"], Float[np.ndarray, "m 2"]],
    places: tuple[Float[np.ndarray, "rows w"], Float[np.ndarray, "h columns"]],
) -> None:
    """Draw triangles into ``depth``.

    Args:
        depth: The image; what is nearer stays.
        uv: Corners on the image that the pixels look at (px).
        inverse_z: 1/z of the corners (1/m).
        bounds: Least and largest u, v of each triangle's pixels.
        places: u and v at which the pixels look.
    """
    height, width = depth.shape
    first = np.maximum(np.ceil(bounds[0]), 0).astype(int)
    last = np.minimum(np.floor(bounds[1]), [width - 1, height - 1]).astype(int)
    ahead, aside = np.diff(uv, axis=1).swapaxes(0, 1)
    # Counter-clockwise to the eye is a negative area where v points down; anything else is seen from behind.
    towards = ahead[:, 0] * aside[:, 1] - ahead[:, 1] * aside[:, 0] < 0.0
    sampled = np.flatnonzero(towards & (first <= last).all(axis=1))
    # Each corner's weight is 1 there and 0 at the two others; weights and 1/z are a + b u + c v.
    weights = np.linalg.inv(np.concatenate([np.ones((len(sampled), 3, 1)), uv[sampled]], axis=2)).swapaxes(1, 2)
    planes = np.concatenate([weights, np.einsum("mi,mij->mj", inverse_z[sampled], weights)[:, None]], axis=1)
    for plane, (left, top), (right, bottom) in zip(planes[..., None, None], first[sampled], last[sampled], strict=True):
        columns, rows = slice(left, right + 1), slice(top, bottom + 1)
        u = places[0][rows if len(places[0]) > 1 else slice(None), columns]
        v = places[1][rows, columns if places[1].shape[1] > 1 else slice(None)]
        *weight, nearness = (plane[:, 0] + plane[:, 1] * u) + plane[:, 2] * v
        inside = (weight[0] >= 0) & (weight[1] >= 0) & (weight[2] >= 0)
        window = depth[rows, columns]
        np.minimum(window, 1.0 / np.where(inside, nearness, 1.0), out=window, where=inside)


_SAMPLE = 100
_FEWEST_PIXELS = 50
_LARGEST_MEAN_SHIFT_PX = 0.1
_LARGEST_SHIFT_PX = 0.5
# Of the pixels along the outline; an edge through pixel centres may tip a whole row of them.
_LARGEST_MISMATCH = 0.25
_LARGEST_RESIDUAL = 0.005
# Depth sensors match windows of about this size, inside of which readings are not independent.
_WINDOW_PIXELS = 25
_MARGIN_PX = 10
_INNER = np.ones((9, 9), np.uint8)
# Cameras that match windows read what is in front for up to ten pixels beside its outline: slits are filled, those
# between the boards of the object itself, too.
_INNER_OF_WINDOWS = np.ones((21, 21), np.uint8)
_STEP = 0.05
"""What is nearer by this fraction of its distance is in front, and no slope."""


@dataclass(frozen=True)
class _Comparison:
    """How a target's files differ from its model drawn at its pose."""

    shift_px: Float[np.ndarray, " 2"]
    mismatch: float
    """Differing pixels over pixels along the outline."""
    residual: float
    """Median of stored minus drawn depth (m)."""
    uncertainty: float
    """Standard error of ``residual`` (m), infinite with too few readings."""
    distance: float
    """Median of drawn depth (m)."""


PROJECTION_NEEDS: tuple[tuple[Output, ...], ...] = (("amodal_masks",), ("masks", "depth"))
"""What a model at its pose is held against: its amodal mask, and depth in its visible one."""


def projection(subject: Subject) -> Findings:
    """Draw a spread sample of targets again from the models and compare amodal masks and depth with the files."""
    built = {obj_id: info.mesh() for obj_id, info in subject.objects.items()}
    findings, comparisons, bias = Findings(), [], subject.manifest.contents.depth_bias
    of_images = [list(group) for _, group in itertools.groupby(_spread_sample(subject), key=lambda pair: id(pair[0]))]
    for compared in subject.each(of_images, lambda pairs: _compare_all(subject, pairs, built)):
        for where, comparison in compared:
            comparisons.append(comparison)
            _judge(findings, comparison, where, bias)
    _judge_all(findings, comparisons, bias)
    return findings


def _judge(findings: Findings, compared: _Comparison, where: str, bias: float) -> None:
    shift = float(np.linalg.norm(compared.shift_px))
    findings.require(
        shift <= _LARGEST_SHIFT_PX and compared.mismatch <= _LARGEST_MISMATCH,
        f"{where}: the model is drawn {shift:.2f} px or more beside its mask; its pose, mesh or camera is wrong",
    )
    limit = 0.01 + 6.0 * compared.uncertainty + bias * compared.distance
    findings.require(
        abs(compared.residual) <= limit,
        f"{where}: stored depth is {compared.residual:.3f} m from the model's, noise explains {limit:.3f} m",
    )


def _judge_all(findings: Findings, comparisons: list[_Comparison], bias: float) -> None:
    if not comparisons:
        findings.examined = "no target whose surface is stored is large enough to compare"
        return
    shift = float(np.linalg.norm(np.mean([item.shift_px for item in comparisons], axis=0)))
    weights = np.array([1.0 / max(item.uncertainty, 1e-4) ** 2 for item in comparisons])
    residuals = np.array([item.residual for item in comparisons])
    residual = float((weights * residuals).sum() / max(weights.sum(), 1e-9))
    findings.require(shift <= _LARGEST_MEAN_SHIFT_PX, f"models are drawn {shift:.3f} px beside their masks on average")
    distance = float((weights * [item.distance for item in comparisons]).sum() / max(weights.sum(), 1e-9))
    allowed = _LARGEST_RESIDUAL + bias * distance
    findings.require(abs(residual) <= allowed, f"stored depth is {residual:.4f} m from the models' on average")
    findings.examined = (
        f"{len(comparisons)} targets: mean shift {shift:.3f} px to the mask, {residual * 1000:.2f} mm to the depth"
    )


def _spread_sample(subject: Subject) -> list[tuple[ImageRecord, TargetRecord]]:
    """Return large enough targets, spread over the dataset; no damaged ones whose own surface is not stored."""
    pairs = []
    for image in subject.images():
        damaged = {
            item.instance_id
            for item in subject.record(image.scene_id).objects
            if item.is_damaged and not subject.layout.damaged_mesh(item.model).is_file()
        }
        pairs += [
            (image, target)
            for target in image.targets
            if target.pixels_visible >= _FEWEST_PIXELS
            and target.obj_id in subject.objects
            and target.instance_id not in damaged
        ]
    step = max(len(pairs) / _SAMPLE, 1.0)
    return [pairs[int(i * step)] for i in range(min(_SAMPLE, len(pairs)))]


def _compare_all(
    subject: Subject, pairs: list[tuple[ImageRecord, TargetRecord]], built: Mapping[int, TriangleMesh]
) -> list[tuple[str, _Comparison]]:
    """Return where and how targets of one image differ, but for those too near to be drawn."""
    has_depth = {"masks", "depth"} <= subject.manifest.contents.outputs
    depth, found = subject.depth(pairs[0][0]) if has_depth else None, []
    for image, target in pairs:
        item = None if target.instance_id is None else subject.record(image.scene_id).object(target.instance_id)
        damaged = None if item is None else read_damaged_mesh(subject.root, item)
        compared = _compare(subject, image, target, built[target.obj_id] if damaged is None else damaged, depth)
        if compared is not None:
            where = f"scene {image.scene_id}, image {image.image_id}, target {target.gt_index}"
            found.append((where, compared))
    return found


def _compare(
    subject: Subject,
    image: ImageRecord,
    target: TargetRecord,
    mesh: TriangleMesh,
    depth: Float32[np.ndarray, "h w"] | None,
) -> _Comparison | None:
    """Return the differences, none from what is not stored, or None if the target is too near to be drawn."""
    sampled = mesh_depth(mesh, target.T_camera_object, image.camera)
    if sampled is None:
        return None
    amodal_mask, shift_px, mismatch = np.isfinite(sampled), np.zeros(2), 0.0
    if "amodal_masks" in subject.manifest.contents.outputs:
        shift_px, mismatch = amodal_mask_shift(subject.readable.mask(image, target.gt_index), amodal_mask)
    if depth is None:
        return _Comparison(shift_px, mismatch, 0.0, np.inf, 0.0)
    visible = subject.readable.mask_visible(image, target.gt_index)
    seen = amodal_mask & (depth > 0) & comparable(visible, sampled, bool(subject.manifest.contents.depth_bias))
    residuals = depth[seen] - sampled[seen]
    if len(residuals) < _FEWEST_PIXELS:
        return _Comparison(shift_px, mismatch, 0.0, np.inf, 0.0)
    median = float(np.median(residuals))
    # 1.4826 times the median deviation is sigma for Gaussian noise, and a median is 1.25 times less sure than a mean.
    sigma = 1.4826 * float(np.median(np.abs(residuals - median)))
    uncertainty = 1.25 * sigma / np.sqrt(max(len(residuals) / _WINDOW_PIXELS, 1.0))
    return _Comparison(shift_px, mismatch, median, uncertainty, float(np.median(sampled[seen])))


def comparable(
    visible: Bool[np.ndarray, "h w"], sampled: Float[np.ndarray, "h w"], windows: bool
) -> Bool[np.ndarray, "h w"]:
    """Return the pixels that nothing in front of them can have lent its depth; ``windows``: by a sensor that lends."""
    around = _INNER_OF_WINDOWS if windows else _INNER
    inner = cv2.erode(visible.astype(np.uint8), around, borderType=cv2.BORDER_CONSTANT, borderValue=1).astype(bool)
    return inner & (cv2.erode(sampled, around) >= (1.0 - _STEP) * sampled) if windows else inner


def amodal_mask_shift(
    mask: Bool[np.ndarray, "h w"], amodal_mask: Bool[np.ndarray, "h w"]
) -> tuple[Float[np.ndarray, " 2"], float]:
    """Return by how much ``mask`` is shifted against ``amodal_mask``, and which fraction of the outline differs.

    The shift (u, v in pixels, true up to about two) is the least-squares solution of Lucas and Kanade (1981) on blurred
    amodal_masks: sharp ones are staircases, whose steps have no slope along the edge. Where the image border cuts the
    amodal mask there is no slope, so nothing is concluded from it.
    """
    box = mask_box_xyxy(mask | amodal_mask)
    if box is None:
        return np.zeros(2), 0.0
    left, top, right, bottom = box
    window = np.s_[max(top - _MARGIN_PX, 0) : bottom + _MARGIN_PX, max(left - _MARGIN_PX, 0) : right + _MARGIN_PX]
    mask, amodal_mask = mask[window], amodal_mask[window]
    mismatch = float(np.count_nonzero(mask != amodal_mask)) / max(_outline_length(amodal_mask), 1)
    there, here = _blurred(mask), _blurred(amodal_mask)
    gradient_v, gradient_u = np.gradient(here)
    slopes = np.stack([gradient_u, gradient_v], axis=-1)[1:-1, 1:-1].reshape(-1, 2)
    difference = (here - there)[1:-1, 1:-1].ravel()
    return np.linalg.lstsq(slopes.T @ slopes, slopes.T @ difference, rcond=None)[0], mismatch


def _blurred(mask: Bool[np.ndarray, "h w"]) -> Float[np.ndarray, "h w"]:
    return cv2.GaussianBlur(mask.astype(np.float64), (0, 0), 1.5, borderType=cv2.BORDER_REPLICATE)


def _outline_length(mask: Bool[np.ndarray, "h w"]) -> int:
    """Return the number of set pixels that have an unset neighbour in the image."""
    return int(np.count_nonzero(mask & ~cv2.erode(mask.astype(np.uint8), np.ones((3, 3), np.uint8)).astype(bool)))
