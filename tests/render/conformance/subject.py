"""The backend under test, and the views that it is compared with exact rays in."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from tests.render.known_box import OFF_CENTRE
from tests.render.referee import Truth, cast_image
from tests.render.scenes import rack_wall
from warehouse_sim.generation.drawn import draw_scene
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, level_camera
from warehouse_sim.render import Renderer
from warehouse_sim.schema import RenderBuffers, SceneSpec

KITTI = PinholeCamera.from_focal(1224, 370, 721.5377)
HALF = PinholeCamera.from_focal(612, 185, 360.76885)


@dataclass(frozen=True, eq=False)
class Subject:
    name: str
    renderer: Renderer

    def draw(
        self, scene: SceneSpec, camera: PinholeCamera, T_world_camera: Transform, normals: bool = False
    ) -> RenderBuffers:
        self.renderer.load(scene)
        return self.renderer.render(camera, T_world_camera, normals=normals)


@dataclass(frozen=True, eq=False)
class View:
    scene: SceneSpec
    camera: PinholeCamera
    T_world_camera: Transform

    def truth(self) -> Truth:
        return cast_image(self.scene, self.camera, self.T_world_camera)


@cache
def smoke_scene() -> SceneSpec:
    """A settled draw of a recipe: worn pallets, wrapped loads, racks and a hall, as datasets are made of."""
    return draw_scene(load_recipe("smoke"), seed=0, scene_index=0).scene


def _wall(camera: PinholeCamera, viewpoint: int) -> View:
    scene = rack_wall()
    return View(scene, camera, scene.viewpoints[viewpoint].T_world_camera)


def _tilted() -> View:
    T = level_camera(np.array([0.5, 1.0, 2.2]), -0.3, -0.35, 0.5)
    return View(rack_wall(), HALF, T)


def _settled() -> View:
    return View(smoke_scene(), HALF, smoke_scene().viewpoints[0].T_world_camera)


VIEWS: dict[str, Callable[[], View]] = {
    "whole image": lambda: _wall(KITTI, 0),
    "off-centre": lambda: _wall(OFF_CENTRE, 1),
    "principal point outside": lambda: _wall(KITTI.crop(700, 210, 300, 160), 2),
    "tilted": _tilted,
    "settled recipe": _settled,
}


@cache
def view(name: str) -> View:
    return VIEWS[name]()


@cache
def truth(name: str) -> Truth:
    return view(name).truth()
