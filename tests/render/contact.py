"""How much darker the floor is beside what stands on it, on rendered images whose geometry is known.

Light is that of sRGB codes, as photographs hold it. Photographs of pallets (three, measured by hand at seven places)
show 0.3 to 0.6 beside the foot, and are back to 0.9 after 0.15 to 0.4 m.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float, Int, UInt8

from warehouse_sim.color import LUMINANCE, linear_from_srgb
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, transform_points
from warehouse_sim.render import open_renderer
from warehouse_sim.schema import ObjectInstance, RenderBuffers, SceneSpec

BESIDE, AROUND = (0.0, 0.05), (0.6, 1.0)
"""Distances (m) from a foot of the floor beside it, and of the floor around."""
_BACK = 0.9
"""Fraction of the floor around from which on the floor counts as such."""
_STEP = 0.05
"""Of distances in a profile (m)."""
_CELL = 0.01
"""Of the map of feet (m)."""
_TOUCHES, _STANDS_OUT, _LEVEL = 0.03, 0.08, 0.004
"""A foot begins below, and ends above (m); the floor is as level as that."""
_WIDEST = 4.0
"""What is wider (m) is a part of the hall, or goes around something."""
_LEAST_PX = 25
_SEED = 515_151


@dataclass(frozen=True)
class Contact:
    """The floor beside one object."""

    ratio: float
    """Light beside its foot over that around."""
    back: float
    """Distance (m) after which the floor is as bright as around; the end of the profile where it never is."""


def summary(found: list[Contact]) -> dict[str, float | int]:
    """Return ``value``, the median ratio, its quartiles, and the median distance after which the floor is as around."""
    ratio, back = (np.array([getattr(item, name) for item in found]) for name in ("ratio", "back"))
    low, value, high = np.quantile(ratio, (0.25, 0.5, 0.75))
    median = float(value), float(np.median(back))
    return {"value": median[0], "n": len(found), "quartile_1": float(low), "quartile_3": float(high), "back": median[1]}


def contacts_of_scene(name: str, index: int) -> Iterator[Contact]:
    """Yield what the viewpoints of a scene of a recipe show."""
    recipe = load_recipe(name)
    scene = prepare_scene(recipe, _SEED, index).scene
    camera = recipe.sensors.make_camera()
    with open_renderer() as renderer:
        renderer.load(scene)
        for viewpoint in scene.viewpoints:
            buffers = renderer.render(camera, viewpoint.T_world_camera)
            yield from contacts(buffers, camera, viewpoint.T_world_camera, scene)


def contacts(
    buffers: RenderBuffers, camera: PinholeCamera, T_world_camera: Transform, scene: SceneSpec
) -> list[Contact]:
    """Return what an image shows of the floor beside each object whose foot it shows."""
    floor = [item.instance_id for item in scene.instances if scene.model_of(item).class_name == "floor"]
    v, u = np.nonzero(np.isin(buffers.instance_mask, floor) & (buffers.depth > 0))
    if len(v) == 0:
        return []
    points = transform_points(T_world_camera, _unprojected(camera, u, v, buffers.depth[v, u]))
    level = np.abs(points[:, 2]) < _LEVEL
    points, light = points[level, :2], luminance(buffers.rgb[v[level], u[level]])
    seen = np.isin([item.instance_id for item in scene.instances], buffers.instance_mask)
    feet = {k: _feet(scene, item) for k, item in enumerate(scene.instances)}
    low, high = points.min(axis=0) - 0.5, points.max(axis=0) + 0.5
    size = np.minimum(np.ceil((high - low) / _CELL).astype(int), 6000)
    number = np.zeros(size[::-1], np.int32)
    for k, polygons in feet.items():
        for polygon in polygons:
            cv2.fillConvexPoly(number, np.rint((polygon - low) / _CELL).astype(np.int32), k + 1)
    distance, label = cv2.distanceTransformWithLabels(
        (number == 0).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    owner_of = np.zeros(label.max() + 1, np.int32)
    owner_of[label[number > 0]] = number[number > 0]
    cells = np.floor((points - low) / _CELL).astype(int)
    inside = (cells < size).all(axis=1)
    column, row = cells[inside].T
    away, owner = distance[row, column] * _CELL, owner_of[label[row, column]]
    found = []
    for k in np.flatnonzero(seen):
        mine = owner == k + 1
        contact = _contact(away[mine], light[inside][mine])
        if contact is not None:
            found.append(contact)
    return found


def _contact(away: Float[np.ndarray, " n"], light: Float[np.ndarray, " n"]) -> Contact | None:
    """Return what a floor's pixels show by their distance from a foot (m); None where there are too few."""
    beside = (away > BESIDE[0]) & (away <= BESIDE[1])
    around = (away > AROUND[0]) & (away <= AROUND[1])
    if beside.sum() < _LEAST_PX or around.sum() < _LEAST_PX:
        return None
    surroundings = float(np.median(light[around]))
    step = (away / _STEP).astype(int)
    last = int(AROUND[0] / _STEP)
    profile = np.array([np.median(light[step == k]) if (step == k).any() else np.nan for k in range(last)])
    bright = np.flatnonzero(profile >= _BACK * surroundings)
    back = float(bright[0] + 0.5) * _STEP if len(bright) else AROUND[0]
    return Contact(float(np.median(light[beside])) / surroundings, back)


def luminance(rgb: UInt8[np.ndarray, "n 3"]) -> Float[np.ndarray, " n"]:
    """Return the linear luminance of sRGB codes."""
    return np.asarray(linear_from_srgb(rgb / 255.0) @ LUMINANCE)


def _feet(scene: SceneSpec, item: ObjectInstance) -> list[Float[np.ndarray, "n 2"]]:
    """Return the outlines (m, world) of the parts of an object that touch the floor and stand out of it."""
    found = []
    for part in scene.model_of(item).parts:
        points = transform_points(item.T_world_object @ part.T_object_part, part.mesh.vertices * part.scale)
        low, high = points[:, 2].min(), points[:, 2].max()
        if -0.05 < low < _TOUCHES and high > _STANDS_OUT:
            outline = cv2.convexHull(points[points[:, 2] < max(low + 0.15, 0.2), :2].astype(np.float32))
            if np.ptp(outline[:, 0], axis=0).max() < _WIDEST:
                found.append(outline[:, 0].astype(float))
    return found


def _unprojected(
    camera: PinholeCamera, u: Int[np.ndarray, " n"], v: Int[np.ndarray, " n"], z: Float[np.ndarray, " n"]
) -> Float[np.ndarray, "n 3"]:
    return np.stack([(u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z, z], axis=1)
