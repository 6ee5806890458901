"""Checks of cameras and labels made by third parties: plausible numbers that go together, nothing listed twice."""

from collections import Counter
from collections.abc import Mapping

import numpy as np
from jaxtyping import Float
from scipy.spatial import cKDTree

from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.checks.subject import ThirdPartySubject
from warehouse_sim.dataset.object_gt import geometry_problems, inside_out
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.mesh import sample_surface
from warehouse_sim.geometry.pose import transform_points

_DIAMETERS = (0.005, 50.0)
"""Of things that one picks up or drives around (m); a slip of units leaves this range or shows in the images."""
_SAMPLES, _PROBES, _MOST_MOTIONS = 20_000, 500, 16
_SAME_SURFACE = 0.02
"""Mean distance, over the diameter, between a measured surface and itself after a symmetry."""


def objects(subject: ThirdPartySubject) -> Findings:
    """Hold sizes, diameters and symmetries against the meshes."""
    findings, infos = Findings(), subject.reader.objects
    if not infos or "meshes" in subject.lacks:
        return Findings(lacking="it holds no meshes")
    for info in infos.values():
        where = f"{subject.root}: object {info.obj_id}"
        for problem in (*geometry_problems(info), *inside_out(info, info.mesh())):
            findings.require(False, f"{where}: {problem}")
        low, high = _DIAMETERS
        findings.require(
            low <= info.diameter <= high,
            f"{where}: the diameter is {info.diameter:.6g} m, {low:g} to {high:g} m is plausible; its unit is wrong",
        )
        _symmetries_hold(findings, info, where)
    findings.examined = f"{len(infos)} objects with their meshes"
    return findings


def _symmetries_hold(findings: Findings, info: ObjectInfo, where: str) -> None:
    """Require that a symmetry moves the surface onto itself, as far as a measured one can tell."""
    motions = info.symmetry.transforms
    if len(motions) == 1:
        return
    surface = sample_surface(info.mesh(), _SAMPLES, np.random.default_rng(0))[0]
    tree, probes = cKDTree(surface), surface[:: _SAMPLES // _PROBES]
    step = max((len(motions) - 1) // _MOST_MOTIONS, 1)
    for index in range(1, len(motions), step):
        apart = float(np.mean(tree.query(transform_points(motions[index], probes))[0])) / info.diameter
        same = findings.require(
            apart < _SAME_SURFACE,
            f"{where}: symmetry {index} moves the surface elsewhere, by {100 * apart:.1f} % of the diameter on average",
        )
        if not same:
            return


_VIEWS_DEG = (1.0, 175.0)
_PIXEL_SHAPES = (0.5, 2.0)
_NEAR = 1e-3
_SAME_FRACTION = 0.02
_SIZES = (0.4, 2.5)
"""Edge of a projected box over that of the stored one; a slip of units is a factor of ten and more."""
_SMALL_PX = 8.0


def cameras(subject: ThirdPartySubject) -> Findings:
    """Look whether each camera could be one, and whether images have one number each."""
    findings, images = Findings(f"{len(subject.images)} cameras"), subject.images
    for image in images:
        where, camera = subject.where(image), image.camera
        for axis, edge, focal, centre in (
            ("x", camera.width, camera.fx, camera.cx),
            ("y", camera.height, camera.fy, camera.cy),
        ):
            view = 2.0 * np.degrees(np.arctan2(edge / 2.0, focal))
            findings.require(
                bool(_VIEWS_DEG[0] < view < _VIEWS_DEG[1]),
                f"{where}: f{axis} {focal:.6g} px gives {edge} px a view of {view:.3g} deg; K or its unit is wrong",
            )
            findings.require(
                0.0 <= centre <= edge,
                f"{where}: c{axis} is {centre:.6g} px, the image has {edge}; K is wrong",
            )
        shape = camera.fx / camera.fy
        findings.require(_PIXEL_SHAPES[0] < shape < _PIXEL_SHAPES[1], f"{where}: fx / fy is {shape:.3g}; K is wrong")
    counts = Counter((image.split, image.scene_id, image.image_id) for image in images)
    for (split, scene, number), count in counts.items():
        findings.require(count == 1, f"{subject.root}: {split} scene {scene}: image {number} comes {count} times")
    return findings


def labels(subject: ThirdPartySubject) -> Findings:
    """Look whether targets are in front of the camera, as large as their boxes, and what their counts say."""
    infos, findings = subject.reader.objects, Findings()
    for image in subject.images:
        poses = [target.T_camera_object.round(9).tobytes() for target in image.targets if target.has_pose]
        twice = next((i for i, pose in enumerate(poses) if pose in poses[:i]), None)
        findings.require(twice is None, f"{subject.where(image)}: target {twice} has the pose of another one")
        for target in image.targets:
            _is_plausible(findings, image, target, infos, f"{subject.where(image)}, target {target.gt_index}")
            findings.count += 1
    if not findings.count:
        return Findings(lacking="it holds no labels")
    bare = sum(not target.has_pose for image in subject.images for target in image.targets)
    more = f"; not checked: {bare} poses, it holds none" if bare else ""
    findings.examined = f"{findings.count} labels of {len(subject.images)} images{more}"
    return findings


def _is_plausible(
    findings: Findings, image: ImageRecord, target: TargetRecord, infos: Mapping[int, ObjectInfo], where: str
) -> None:
    if infos and not findings.require(target.obj_id in infos, f"{where}: obj_id {target.obj_id} is no known object"):
        return
    place = target.T_camera_object[:3, 3]
    behind = target.has_pose and not place[2] > _NEAR
    if not findings.require(not behind, f"{where}: is behind the camera, z = {place[2]:.6g} m"):
        return
    fraction = target.pixels_visible / max(target.pixels_all, 1)
    findings.require(
        abs(min(fraction, 1.0) - target.visible_fraction) < _SAME_FRACTION,
        f"{where}: visib_fract is {target.visible_fraction:.4g}, {target.pixels_visible} of {target.pixels_all} px is "
        f"{fraction:.4g}",
    )
    if infos and target.has_pose and target.info(infos).diameter > 0.0:
        _has_size(findings, image, target, target.info(infos), where)


def _has_size(findings: Findings, image: ImageRecord, target: TargetRecord, info: ObjectInfo, where: str) -> None:
    """Require that the projected object is about as large as its box, which lies about there."""
    corners = transform_points(target.T_camera_object, box_corners(info.size))
    stored = np.array(target.box_amodal_xyxy)
    if corners[:, 2].min() < _NEAR * 50:
        findings.require(info.diameter < 50.0 * target.T_camera_object[2, 3], f"{where}: {_units(np.inf)}")
        return
    uv = image.camera.project(corners)
    last = np.array([image.camera.width - 1.0, image.camera.height - 1.0])
    ends = np.concatenate([np.clip(uv.min(axis=0), 0, last), np.clip(uv.max(axis=0), 0, last)])
    box = np.clip(stored, 0, np.tile(last, 2))
    found, wanted = _largest_edge(ends), _largest_edge(box)
    if wanted < _SMALL_PX:
        return
    factor = found / wanted
    if findings.require(_SIZES[0] < factor < _SIZES[1], f"{where}: {_units(factor)}"):
        apart = float(np.abs((ends[:2] + ends[2:] - box[:2] - box[2:]) / 2.0).max())
        findings.require(
            apart < 0.5 * max(found, wanted) + 2.0,
            f"{where}: the object is projected {apart:.0f} px beside its box; its pose, K or box is wrong",
        )


def _largest_edge(box_xyxy: Float[np.ndarray, "4"]) -> float:
    return float((box_xyxy[2:] - box_xyxy[:2]).max())


def _units(factor: float) -> str:
    return (
        f"the object is projected {factor:.3g} times as large as its box; model or translation may be in metres where "
        "millimetres are meant, or the other way round"
    )
