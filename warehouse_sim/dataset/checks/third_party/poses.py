"""Check that third-party models at their poses land on their masks and depth."""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.dataset.checks.depth import point_depth, range_fraction
from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.checks.subject import ThirdPartySubject
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.geometry.mesh import sample_surface

_SAMPLE, _POINTS = 200, 60_000
_FEWEST_POINTS, _POINTS_PER_PIXEL = 3_000, 12.0
_FEWEST_PIXELS = 100
_FINE_PIXELS = 300
_LEAST_INSIDE, _LEAST_IOU = 0.75, 0.7
_WHOLLY_SEEN = 0.95
_INNER = np.ones((5, 5), np.uint8)
_FAR_OFF, _FAR_OFF_DIAMETERS = 0.05, 0.25
"""By so much of the distance, or of the object's diameter, depth may differ from the model's."""
_PROBES = 500


@dataclass(frozen=True, eq=False)
class _Compared:
    findings: Findings
    z: Float[np.ndarray, " n"]
    """Depth of the model at pixels of the target (m); then its distance, and what was read there."""
    distance: Float[np.ndarray, " n"]
    read: Float[np.ndarray, " n"]


def poses(subject: ThirdPartySubject) -> Findings:
    """Draw a spread sample of targets from points on their models, and compare with masks and depth."""
    infos = subject.reader.objects
    if not infos or "meshes" in subject.lacks:
        return Findings(lacking="it holds no meshes")
    rng = np.random.default_rng(0)
    surfaces = {number: sample_surface(info.mesh(), _POINTS, rng)[0] for number, info in infos.items()}
    pairs = [
        (image, target)
        for image in subject.images
        for target in image.targets
        if target.has_pose and target.obj_id in infos and target.pixels_visible >= _FEWEST_PIXELS
    ]
    step = max(len(pairs) / _SAMPLE, 1.0)
    chosen = [pairs[int(i * step)] for i in range(min(_SAMPLE, len(pairs)))]
    compared = list(subject.each(chosen, lambda pair: _compare(subject, *pair, surfaces[pair[1].obj_id])))
    count = sum(item.findings.count for item in compared)
    if not count:
        return Findings(lacking="no target is large enough, or none is labelled")
    findings = Findings()
    z, distance, read = np.concatenate([[item.z, item.distance, item.read] for item in compared], axis=1)
    # What is wrong everywhere comes first: it explains the rest.
    findings.require(
        range_fraction(read, z, distance) < 0.5,
        f"{subject.root}: depth images hold the distance to the camera, not the depth along its axis",
    )
    for item in compared:
        findings.add(item.findings)
    off = f", depth {1000 * float(np.median(read - z)):.1f} mm beside the models" if len(z) else ", not checked: depth"
    findings.examined = f"{count} of {len(pairs)} targets{off}"
    return findings


def _compare(
    subject: ThirdPartySubject, image: ImageRecord, target: TargetRecord, surface: Float[np.ndarray, "n 3"]
) -> _Compared:
    findings, empty = Findings(), np.zeros(0)
    where = f"{subject.where(image)}, target {target.gt_index}"
    left, top, right, bottom = target.box_amodal_xyxy
    needed = int(np.clip(_POINTS_PER_PIXEL * (right - left + 1) * (bottom - top + 1), _FEWEST_POINTS, len(surface)))
    sampled = point_depth(surface[:needed], target.T_camera_object, image.camera)
    if sampled is None:
        return _Compared(findings, empty, empty, empty)
    findings.count = 1
    visible = subject.reader.mask_visible(image, target.gt_index)
    amodal_mask = np.isfinite(sampled)
    _lies_on_model(findings, visible, amodal_mask, where)
    whole = visible if target.visible_fraction >= _WHOLLY_SEEN else subject.reader.mask(image, target.gt_index)
    if "amodal masks" not in subject.lacks or target.visible_fraction >= _WHOLLY_SEEN:
        _has_its_shape(findings, whole, amodal_mask, where)
    if "depth" in subject.lacks:
        return _Compared(findings, empty, empty, empty)
    depth = subject.reader.depth(image).astype(np.float64)
    inner = cv2.erode((visible & amodal_mask).astype(np.uint8), _INNER, borderValue=0) > 0
    v, u = np.nonzero(inner & (depth > 0))
    if len(v) < _FEWEST_PIXELS // 4:
        return _Compared(findings, empty, empty, empty)
    z, read = sampled[v, u], depth[v, u]
    _depth_agrees(findings, z, read, subject.reader.objects[target.obj_id].diameter, where)
    chosen = slice(None, None, max(len(z) // _PROBES, 1))
    rays = image.camera.rays()[v, u]
    distance = z * np.linalg.norm(rays / rays[:, 2:], axis=1)
    return _Compared(findings, z[chosen], distance[chosen], read[chosen])


def _lies_on_model(
    findings: Findings, visible: Bool[np.ndarray, "h w"], amodal_mask: Bool[np.ndarray, "h w"], where: str
) -> None:
    """Require most of a visible mask on the projected model; a box that stands for one may be the larger of both."""
    both, count, sampled = (int(np.count_nonzero(item)) for item in (visible & amodal_mask, visible, amodal_mask))
    inside = both / max(min(count, sampled) if _is_rectangle(visible) else count, 1)
    findings.require(
        inside >= _LEAST_INSIDE,
        f"{where}: only {100 * inside:.0f} % of its visible mask lie on the projected model; pose, model, K or mask is "
        "wrong",
    )


def _has_its_shape(
    findings: Findings, mask: Bool[np.ndarray, "h w"], amodal_mask: Bool[np.ndarray, "h w"], where: str
) -> None:
    """Require that projected model and whole mask are alike, where pixels are fine enough and the mask is no box."""
    both, either = (int(np.count_nonzero(item)) for item in (mask & amodal_mask, mask | amodal_mask))
    if either < _FINE_PIXELS or _is_rectangle(mask):
        return
    findings.require(
        both >= _LEAST_IOU * either,
        f"{where}: projected model and mask share {100 * both / either:.0f} % of their pixels; "
        "pose, model, K or mask is wrong",
    )


def _is_rectangle(mask: Bool[np.ndarray, "h w"]) -> bool:
    edges = [int(np.count_nonzero(mask.any(axis=axis))) for axis in (0, 1)]
    return bool(np.count_nonzero(mask) == edges[0] * edges[1])


def _depth_agrees(
    findings: Findings, z: Float[np.ndarray, " n"], read: Float[np.ndarray, " n"], diameter: float, where: str
) -> None:
    off, middle = float(np.median(read - z)), float(np.median(z))
    factor = float(np.median(read / z))
    hint = f"; it is {factor:.3g} times as far: depth_scale or its unit is wrong" if not 0.5 < factor < 2.0 else ""
    findings.require(
        abs(off) <= max(_FAR_OFF * middle, _FAR_OFF_DIAMETERS * diameter),
        f"{where}: stored depth is {off:.3f} m from the model's{hint}",
    )
