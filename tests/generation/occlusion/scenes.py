"""A bare hall with few things, seen along +y."""

import numpy as np

from warehouse_sim.catalog import materials
from warehouse_sim.generation.occlusion.config import FractionRange, VisibleFractions
from warehouse_sim.generation.occlusion.occluded_scene import OccludedScene
from warehouse_sim.generation.occlusion.occluder import Occluder
from warehouse_sim.generation.occlusion.sight import Sight
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, level_camera, make_transform, rotation_z
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.schema import SceneSpec, Viewpoint

CAMERA = PinholeCamera.from_focal(640, 360, 400.0)
AREA = Area(-5.0, 5.0, -5.0, 5.0)
EYE = np.array([0.0, -4.5, 1.4])
VIEW = Viewpoint(level_camera(EYE, np.pi / 2, -0.15), kind="level", target=2)


def on_floor(
    draft: SceneDraft, name: str, x: float, y: float, yaw: float = 0.0, z: float = 0.0, loose: bool = True
) -> None:
    """Put a catalog object on the floor, or on something ``z`` (m) high."""
    group = draft.new_group() if loose else 0
    item = draft.add(name, make_transform(rotation_z(yaw), np.array([x, y, 0.0])), group)
    item.T_world_object[2, 3] = z + draft.models[item.model].size[2] / 2


def hall(*things: tuple[str, float, float], loose: bool = True) -> SceneSpec:
    """Return a slab with a pallet as the target (instance 2) in its middle, and more things at (x, y)."""
    draft = SceneDraft()
    on_floor(draft, "floor_slab", 0.0, 0.0, z=-0.2, loose=False)
    for name, x, y in (("epal1", 0.0, 0.0), *things):
        on_floor(draft, name, x, y, loose=loose)
    bounds = (AREA.x_min, AREA.x_max, AREA.y_min, AREA.y_max)
    return SceneSpec(0, 0, draft.models, materials(), tuple(draft.instances), (), (VIEW,), settled=True, aisle=bounds)


def occluded_scene_of(scene: SceneSpec) -> OccludedScene:
    return OccludedScene(scene, RayCaster(scene), CAMERA, AREA, 0.8)


def sight_of(occluded: OccludedScene, rays: int = 2000) -> Sight:
    sight = occluded.look(2, VIEW.T_world_camera, rays)
    assert sight is not None
    return sight


def box_of(occluder: Occluder, T_world_occluder: Transform) -> OrientedBox:
    return OrientedBox(T_world_occluder @ occluder.envelope.T_parent_box, occluder.envelope.size)


DECILES = VisibleFractions(tuple(FractionRange(step / 10, (step + 1) / 10) for step in range(1, 10)))
"""Ranges of width 0.1 from 0.1 to 1."""
