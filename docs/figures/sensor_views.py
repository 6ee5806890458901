"""Views of a settled warehouse, with all that a sensor model requires, to draw what the sensors make of them."""

from dataclasses import dataclass, replace

import numpy as np

from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.render.renderer import Renderer
from warehouse_sim.scene.lighting.exposure import ev_of_exposure
from warehouse_sim.schema import RenderBuffers, SceneSpec, Viewpoint
from warehouse_sim.sensors.motion import camera_motion
from warehouse_sim.sensors.surfaces import see_surfaces
from warehouse_sim.sensors.view import Capture

CAMERA = PinholeCamera.from_focal(640, 360, 424.0)


@dataclass(frozen=True, eq=False)
class View:
    """The clean ground truth of one image, and how it is taken."""

    buffers: RenderBuffers
    capture: Capture


def scene_before_pallet(recipe: str = "demo", distance: float = 2.0, height: float = 0.42) -> SceneSpec:
    """Return a scene with one viewpoint, level and before a pallet on the floor.

    Args:
        recipe: Its name.
        distance: From the pallet's centre to the camera (m).
        height: Of the camera (m).
    """
    scene = prepare_scene(load_recipe(recipe), 0, 0).scene
    low = [item for item in scene.target_instances() if item.T_world_object[2, 3] < 0.2]
    place = max(low, key=lambda item: item.T_world_object[1, 3] - abs(item.T_world_object[0, 3])).T_world_object[:3, 3]
    pose = level_camera(np.array([place[0] + 0.3, place[1] - distance, height]), np.pi / 2)
    return replace(scene, viewpoints=(Viewpoint(pose, exposure=scene.exposure),))


def see(scene: SceneSpec, viewpoint: Viewpoint, renderer: Renderer, camera: PinholeCamera = CAMERA) -> View:
    """Draw a viewpoint of a scene."""
    lit = scene.seen_from(viewpoint)
    renderer.load(lit)
    buffers = renderer.render(camera, viewpoint.T_world_camera, normals=True)
    surfaces = see_surfaces(scene, RayCaster(scene), camera, viewpoint.T_world_camera, reflections=True)
    return View(buffers, Capture(camera, ev_of_exposure(lit.exposure), camera_motion(viewpoint), surfaces))
