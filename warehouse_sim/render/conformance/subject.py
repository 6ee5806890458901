"""The backend under test, and the views that it is compared with exact rays in."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, level_camera
from warehouse_sim.render.conformance.known_box import OFF_CENTRE
from warehouse_sim.render.conformance.referee import GroundTruth, cast_image
from warehouse_sim.render.conformance.scenes import rack_wall
from warehouse_sim.render.renderer import Renderer
from warehouse_sim.schema import RenderBuffers, SceneSpec

KITTI = PinholeCamera.from_focal(1224, 370, 721.5377)
HALF = PinholeCamera.from_focal(612, 185, 360.76885)
_OTHERS = "raster|pathtrace"
"""A rejection names a backend that can."""


@dataclass(frozen=True, eq=False)
class Subject:
    """An open backend and the name that it is registered under."""

    name: str
    renderer: Renderer

    def render(
        self, scene: SceneSpec, camera: PinholeCamera, T_world_camera: Transform, normals: bool = False
    ) -> RenderBuffers:
        """Load ``scene`` and draw one view of it."""
        self.renderer.load(scene)
        return self.renderer.render(camera, T_world_camera, normals=normals)

    def expect(self, ok: object, what: str) -> None:
        """Raise a RenderError that names the backend unless ``ok``."""
        if not ok:
            raise RenderError(f"the {self.name} backend does not conform: {what}")

    def expect_rejection(self, call: Callable[[], object], pattern: str) -> None:
        """Expect that ``call`` raises a RenderError whose message holds the regular expression ``pattern``."""
        try:
            call()
        except RenderError as error:
            self.expect(
                re.search(pattern, str(error)), f"it rejects with {str(error)!r}, which does not say {pattern!r}"
            )
            return
        self.expect(False, f"it should have rejected with {pattern!r}")

    def expect_cannot(self, call: Callable[[], object], product: str) -> None:
        """Expect that ``call`` is rejected since the backend draws no ``product``, with the name of one that does."""
        self.expect_rejection(call, f"the {self.name} backend draws no {product}; use .*({_OTHERS})")


@dataclass(frozen=True, eq=False)
class View:
    """A camera in a scene."""

    scene: SceneSpec
    camera: PinholeCamera
    T_world_camera: Transform

    @cached_property
    def gt(self) -> GroundTruth:
        """What exact rays see."""
        return cast_image(self.scene, self.camera, self.T_world_camera)


def _wall(camera: PinholeCamera, viewpoint: int) -> View:
    scene = rack_wall()
    return View(scene, camera, scene.viewpoints[viewpoint].T_world_camera)


def _tilted() -> View:
    T = level_camera(np.array([0.5, 1.0, 2.2]), -0.3, -0.35, 0.5)
    return View(rack_wall(), HALF, T)


VIEWS: dict[str, Callable[[], View]] = {
    "whole image": lambda: _wall(KITTI, 0),
    "off-centre": lambda: _wall(OFF_CENTRE, 1),
    "principal point outside": lambda: _wall(KITTI.crop(700, 210, 300, 160), 2),
    "tilted": _tilted,
}


@cache
def view(name: str) -> View:
    """Return a view of ``VIEWS``; what exact rays see there is cast once."""
    return VIEWS[name]()
