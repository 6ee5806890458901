"""An image is that of its view: neither the scene's other viewpoints nor what was requested before change it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.render import AmodalMask, Renderer
from warehouse_sim.render.conformance.scenes import rack_wall, spot
from warehouse_sim.render.lens import LensRenderer
from warehouse_sim.schema import SceneSpec, Viewpoint

pytestmark = pytest.mark.gl

CAMERA = PinholeCamera.from_focal(320, 200, 190.0)


def hall_of_many_lights() -> SceneSpec:
    """More lights than any rasteriser shades, of different strength, along a wall of racks."""
    wall = rack_wall()
    lights = [spot((1.5, y, 6.5), 1500.0 + 100.0 * number) for number, y in enumerate(np.linspace(-9.0, 9.0, 20))]
    return replace(wall, lights=tuple(lights))


def render_all(renderer: Renderer, scene: SceneSpec, viewpoints: Sequence[Viewpoint]) -> list[bytes]:
    """Return what is rendered from ``viewpoints`` of a scene that holds just these."""
    renderer.load(replace(scene, viewpoints=tuple(viewpoints)))
    sampled = [renderer.render(CAMERA, view.T_world_camera) for view in viewpoints]
    return [item.rgb.tobytes() + item.depth.tobytes() + item.instance_mask.tobytes() for item in sampled]


def same(a: Sequence[AmodalMask], b: Sequence[AmodalMask]) -> bool:
    return all(x.offset == y.offset and np.array_equal(x.mask, y.mask) for x, y in zip(a, b, strict=True))


def test_a_view_looks_the_same_alone_among_others_and_in_another_order(renderer: Renderer) -> None:
    scene = hall_of_many_lights()
    views = scene.viewpoints
    together = render_all(renderer, scene, views)
    assert render_all(renderer, scene, views[::-1]) == together[::-1]
    for view, image in zip(views, together, strict=True):
        assert render_all(renderer, scene, [view]) == [image]
    assert len(set(together)) == len(views)


def test_an_image_does_not_depend_on_the_image_before(renderer: Renderer) -> None:
    scene = hall_of_many_lights()
    first, *_, last = scene.viewpoints
    renderer.load(scene)
    before = renderer.render(CAMERA, first.T_world_camera).rgb
    renderer.render(CAMERA, last.T_world_camera)
    assert np.array_equal(renderer.render(CAMERA, first.T_world_camera).rgb, before)


@pytest.mark.parametrize("lens", [None, Distortion(-0.28, 0.08, 0.0, 0.0)], ids=["pinhole", "lens"])
def test_amodal_masks_are_the_same_before_and_after_an_image(renderer: Renderer, lens: Distortion | None) -> None:
    scene, camera = rack_wall(), replace(CAMERA, distortion=lens)
    drawing = LensRenderer(renderer)
    things = [item for item in scene.instances if scene.model_of(item).class_name != "floor"]
    for view in scene.viewpoints:
        drawing.load(scene)
        before = drawing.amodal_masks(camera, view.T_world_camera, things)
        ids = drawing.render(camera, view.T_world_camera).instance_mask
        after = drawing.amodal_masks(camera, view.T_world_camera, things)
        drawing.render(camera, scene.viewpoints[0].T_world_camera)
        assert same(before, after)
        assert same(after, drawing.amodal_masks(camera, view.T_world_camera, things))
        assert len(np.unique(ids)) > 10
