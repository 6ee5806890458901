"""Checks that a dataset has one camera: that of camera.json, of every table, of the calibration and of the recipe."""

import numpy as np

from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.dataset.files.plain import read_lens, take
from warehouse_sim.dataset.formats.bop.layout import bop_layout
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.fisheye import Lens, same_lens

_KEYS = ("fx", "fy", "cx", "cy")


def cameras(subject: Subject) -> Findings:
    """Hold camera.json and each row of scene_camera.json against each other and the recipe."""
    bop = bop_layout(subject.root)
    path, recipe_camera = bop.camera, subject.manifest.contents.camera
    data, where = read_json(path), str(path)
    values = {key: take(data, key, float, where) for key in (*_KEYS, "depth_scale")}
    size_wh = take(data, "width", int, where), take(data, "height", int, where)
    lens = read_lens(data, where)
    findings, count = Findings(), 0
    if recipe_camera is not None:
        same = size_wh == (recipe_camera.width, recipe_camera.height)
        findings.require(same and _same(values, lens, recipe_camera.make()), f"{path}: is not the camera of the recipe")
    for image in subject.images():
        table = bop.scene(image.split, image.scene_id).table("camera")
        same = _same(values, lens, image.camera) and image.depth_scale == values["depth_scale"]
        findings.require(same, f"{table}: {image.image_id}: is not the camera of {path}")
        count += 1
    findings.examined = f"{count} cameras, those of camera.json and the recipe"
    return findings


def _same(values: dict[str, float], lens: Lens | None, camera: PinholeCamera) -> bool:
    same = np.allclose([values[key] for key in _KEYS], [getattr(camera, key) for key in _KEYS], rtol=1e-9)
    return bool(same) and same_lens(lens, camera.distortion)
