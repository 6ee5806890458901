"""Grain, tints and worn edges: what one sees on pixels, and that nothing but colour knows of them."""

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.catalog.materials import materials
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render import Renderer
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.render.raster.meshes.parts import _length_codes
from warehouse_sim.schema import Material, RenderBuffers, SceneSpec

pytestmark = pytest.mark.gl

CAMERA = PinholeCamera.from_focal(320, 240, 300.0)
FROM = level_camera(np.array([0.0, -2.0, 0.3]), np.pi / 2)


def row_of_boxes(material: str, count: int = 5, size: tuple[float, float, float] = (0.3, 0.3, 0.3)) -> SceneSpec:
    """Return boxes side by side before the camera, in one material of the catalog."""
    model = box_model("box", size, material)
    places = [at((number - (count - 1) / 2) * size[0], 0.0, 0.3) for number in range(count)]
    scene = make_scene([model], [("box", place) for place in places], materials=materials(), ambient=300.0)
    return replace(scene, exposure=0.008)


def seen(renderer: Renderer, scene: SceneSpec) -> RenderBuffers:
    renderer.load(scene)
    return renderer.render(CAMERA, FROM, normals=True)


def plain(scene: SceneSpec) -> SceneSpec:
    """Return ``scene`` without textures."""
    bare: dict[str, Material] = {name: replace(item, texture=None) for name, item in scene.materials.items()}
    return replace(scene, materials=bare)


def brightness_of(buffers: RenderBuffers, number: int) -> float:
    inside = buffers.instance_mask == number
    return float(buffers.rgb[inside].mean())


def test_single_cartons_of_one_board_differ_and_painted_boxes_do_not(renderer: Renderer) -> None:
    spread = {}
    for name in ("kraft", "rack_blue"):
        buffers = seen(renderer, row_of_boxes(name))
        tones = np.array([brightness_of(buffers, number) for number in range(1, 6)])
        spread[name] = tones.std() / tones.mean()
    assert spread["kraft"] > 0.02
    assert spread["rack_blue"] < 0.02


def test_a_joint_between_flush_cartons_is_dark(renderer: Renderer) -> None:
    image = seen(renderer, row_of_boxes("kraft", 2)).rgb.mean(axis=2)
    middle = image[90:150].mean(axis=0)
    joint = middle[158:162].min()
    assert joint < 0.9 * np.median(middle[130:155])
    assert joint < 0.9 * np.median(middle[165:190])


def test_grain_shows_in_the_finest_octave_of_an_image(renderer: Renderer) -> None:
    """On concrete, 2 m before a camera that sees 7 mm a pixel."""
    image = seen(renderer, row_of_boxes("concrete", 1, (2.0, 0.3, 2.0))).rgb.mean(axis=2)
    part = image[60:180, 80:240]
    assert 0.02 < np.diff(part, axis=1).std() / np.sqrt(2) / part.mean() < 0.12


def test_depth_ids_and_normals_know_nothing_of_it(renderer: Renderer) -> None:
    scene = row_of_boxes("kraft")
    grained, bare = seen(renderer, scene), seen(renderer, plain(scene))
    assert not np.array_equal(grained.rgb, bare.rgb)
    assert grained.normals is not None
    assert bare.normals is not None
    for one, other in (
        (grained.depth, bare.depth),
        (grained.instance_mask, bare.instance_mask),
        (grained.normals, bare.normals),
    ):
        assert one.tobytes() == other.tobytes()


def test_lengths_of_edges_are_kept_to_a_few_per_cent() -> None:
    half = np.array([[0.002, 0.05, 0.3], [1.0, 20.0, 60.0]])
    kept = 2.0 ** (_length_codes(half) / 16.0 - 10.0)
    np.testing.assert_allclose(kept, half, rtol=0.025)
