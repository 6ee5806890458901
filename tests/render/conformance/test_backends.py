"""Every registered backend conforms, and the checks see what does not."""

from dataclasses import replace
from functools import cache

import pytest

from warehouse_sim.errors import RenderError
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import sample_settled_scene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render import Renderer
from warehouse_sim.render.conformance import CHECKS, Subject, channels
from warehouse_sim.render.conformance.channels import check_view
from warehouse_sim.render.conformance.subject import HALF, View
from warehouse_sim.schema import RenderBuffers, SceneSpec

pytestmark = pytest.mark.gl


@cache
def settled_view() -> View:
    """A settled draw of a recipe: damaged pallets, wrapped loads, racks and a hall, as datasets are made of."""
    scene = sample_settled_scene(load_recipe("smoke"), 0, 0).scene
    return View(scene, HALF, scene.viewpoints[0].T_world_camera)


@pytest.mark.parametrize("name", CHECKS)
def test_a_registered_backend_conforms(subject: Subject, name: str) -> None:
    CHECKS[name](subject)


def test_every_channel_of_a_settled_recipe_agrees_with_ray_casting(subject: Subject) -> None:
    check_view(subject, settled_view())


class Shifted:
    """A renderer that is half a pixel off in one channel, and forgets what it declares."""

    def __init__(self, renderer: Renderer, channel: str) -> None:
        self._renderer, self._channel = renderer, channel
        self.description = "raster of version 1"
        self.capabilities = replace(renderer.capabilities, textures=False, max_lights=3)

    def load(self, scene: SceneSpec) -> None:
        self._renderer.load(scene)

    def render(self, camera: PinholeCamera, T_world_camera: Transform, normals: bool = False) -> RenderBuffers:
        beside = replace(camera, cx=camera.cx + 0.5)
        sampled, moved = (self._renderer.render(item, T_world_camera, normals) for item in (camera, beside))
        return replace(sampled, **{self._channel: getattr(moved, self._channel)})


@pytest.mark.parametrize(
    ("channel", "name", "message"),
    [
        ("rgb", "registration", r"the raster backend does not conform: rgb lies 0\.\d+ px beside"),
        ("instance_mask", "registration", r"mask lies 0\.\d+ px beside"),
        ("depth", "registration", r"depth"),
        ("depth", "channels: tilted", r"depth"),
        ("rgb", "textures", r"textures: declared False, found True"),
        ("rgb", "lights", r"16 of 20 lights are rendered, 3 are declared"),
    ],
)
def test_what_does_not_conform_is_said(
    renderer: Renderer, monkeypatch: pytest.MonkeyPatch, channel: str, name: str, message: str
) -> None:
    monkeypatch.setattr(channels, "_PLACEMENTS", 6)  # half a pixel shows in a few
    with pytest.raises(RenderError, match=message):
        CHECKS[name](Subject("raster", Shifted(renderer, channel)))  # type: ignore[arg-type]
