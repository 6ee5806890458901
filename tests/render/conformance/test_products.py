"""What a backend declares it does, and what it does not declare it refuses or leaves out: nothing is faked."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from tests.render.conformance.subject import OFF_CENTRE, Subject, view
from tests.render.referee import cast_image
from tests.render.scenes import MATERIALS, at, box_model, make_scene, spot
from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render import Silhouette
from warehouse_sim.schema import Light, Material, RenderBuffers, SceneSpec

pytestmark = pytest.mark.gl

CAMERA = PinholeCamera.from_focal(320, 200, 220.0)
FROM_ABOVE = level_camera(np.array([0.0, 0.0, 6.0]), 0.0, -np.pi / 2)
AT_CARTON = level_camera(np.array([-3.0, 0.0, 1.2]), 0.0, -0.25)
FLOOR = box_model("floor", (40, 40, 0.1), "concrete", "floor", 90)
OTHERS = "raster|pathtrace"
"""A refusal names a backend that can."""


def patch_levels(buffers: RenderBuffers, pixels: list[tuple[int, int]]) -> np.ndarray:
    """Return the brightness around each of ``pixels`` (column, row)."""
    return np.array([buffers.rgb[v - 3 : v + 4, u - 3 : u + 4].mean() for u, v in pixels])


def film_scene(material: Material | None) -> SceneSpec:
    """A carton on the floor before the camera, wrapped in ``material``."""
    models = [FLOOR, box_model("carton", (0.6, 0.6, 0.6)), box_model("wrap", (0.62, 0.62, 0.62), "film", "wrap", 91)]
    placed = [("floor", at(0, 0, -0.05)), ("carton", at(0, 0, 0.3)), ("wrap", at(0, 0, 0.3))]
    film = material or Material("film", (0.5,) * 3)
    lamp = spot((-2.0, 1.0, 3.5), 2500.0)
    scene = make_scene(models, placed, [lamp], materials={**MATERIALS, "film": film}, ambient=60.0)
    return scene if material is not None else replace(scene, instances=scene.instances[:2])


def test_normals_are_drawn_or_refused(subject: Subject) -> None:
    seen = view("off-centre")
    subject.renderer.load(seen.scene)
    if not subject.renderer.capabilities.normals:
        with pytest.raises(RenderError, match=f"the {subject.name} backend draws no normals; use .*({OTHERS})"):
            subject.renderer.render(seen.camera, seen.T_world_camera, normals=True)
    else:
        assert subject.renderer.render(seen.camera, seen.T_world_camera, normals=True).normals is not None
    assert subject.renderer.render(seen.camera, seen.T_world_camera).normals is None


def on_canvas(silhouette: Silhouette, camera: PinholeCamera) -> np.ndarray:
    """Return the silhouette on the canvas of 3W x 3H with the image in the middle."""
    canvas = np.zeros((3 * camera.height, 3 * camera.width), bool)
    left, top = silhouette.offset[0] + camera.width, silhouette.offset[1] + camera.height
    height, width = silhouette.mask.shape
    canvas[top : top + height, left : left + width] = silhouette.mask
    return canvas


def test_silhouettes_are_those_of_rays_at_the_object_alone_or_refused(subject: Subject) -> None:
    scene, camera = view("off-centre").scene, PinholeCamera(150, 100, 125.0, 120.0, 70.0, 45.0)
    T, pallets = scene.viewpoints[2].T_world_camera, scene.target_instances()
    subject.renderer.load(scene)
    if not subject.renderer.capabilities.silhouettes:
        with pytest.raises(RenderError, match=f"the {subject.name} backend draws no silhouettes; use .*({OTHERS})"):
            subject.renderer.silhouettes(camera, T, pallets)
        return
    ids = subject.renderer.render(camera, T).instance_ids
    found = subject.renderer.silhouettes(camera, T, pallets)
    wide = camera.crop(-camera.width, -camera.height, 3 * camera.width, 3 * camera.height)
    beyond = 0
    for pallet, silhouette in zip(pallets, found, strict=True):
        exact = cast_image(replace(scene, instances=(pallet,)), wide, T).instance_ids > 0
        drawn = on_canvas(silhouette, camera)
        rim = cv2.morphologyEx(exact.astype(np.uint8), cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8)) > 0
        assert (drawn == exact)[~rim].all()
        assert np.count_nonzero(drawn != exact) <= 2 + 0.02 * np.count_nonzero(rim)
        image = drawn[camera.height : 2 * camera.height, camera.width : 2 * camera.width]
        assert not ((ids == pallet.instance_id) & ~image).any()
        beyond += 0 < image.sum() < drawn.sum()
    assert beyond >= 2


def test_film_tints_the_picture_or_is_left_out_and_never_touches_a_label(subject: Subject) -> None:
    bare, wrapped = (
        subject.draw(film_scene(film), CAMERA, AT_CARTON) for film in (None, Material("film", (0.9,) * 3, opacity=0.5))
    )
    assert np.array_equal(bare.instance_ids, wrapped.instance_ids)
    assert np.array_equal(bare.depth, wrapped.depth)
    if not subject.renderer.capabilities.film:
        assert np.array_equal(bare.rgb, wrapped.rgb)
        return
    # Means over many pixels, in which a path tracer's noise is small.
    change = np.abs(cv2.blur(wrapped.rgb.astype(np.float32) - bare.rgb, (11, 11))).max(axis=2)
    assert np.median(change[wrapped.instance_ids == 2]) > 8
    # It casts no shadow: what it changes of the floor is its own outline.
    assert (change[wrapped.instance_ids == 1] > 12).mean() < 0.05


def test_textures_structure_what_is_plain_without_them(subject: Subject) -> None:
    spread = {}
    for texture in (None, "concrete"):
        materials = {**MATERIALS, "concrete": replace(MATERIALS["concrete"], texture=texture, texture_size=3.0)}
        lamps = [spot((0.0, 0.0, 7.0), 6000.0)]
        scene = make_scene([FLOOR], [("floor", at(0, 0, -0.05))], lamps, materials=materials, ambient=200.0)
        rgb = subject.draw(scene, CAMERA, FROM_ABOVE).rgb[40:160, 80:240].astype(np.float32)
        fine = cv2.blur(rgb, (9, 9)) - cv2.blur(rgb, (61, 61))
        spread[texture] = float(fine.std())
    assert (spread["concrete"] > spread[None] + 0.5) == subject.renderer.capabilities.textures


def test_a_lamp_over_a_table_shades_the_floor_below(subject: Subject) -> None:
    models = [FLOOR, box_model("table", (1.2, 1.2, 0.05))]
    placed = [("floor", at(0, 0, -0.05)), ("table", at(0.0, 0.0, 1.5))]
    scene = make_scene(models, placed, [spot((0.0, 3.0, 5.0), 6000.0)], ambient=40.0)
    # The lamp's rays over the middle of the table reach the floor at y = 3 - 3 * 5 / 3.5: right in the picture.
    below, beside = (160 + round(220 / 6 * 1.29), 100), (160 - round(220 / 6 * 1.29), 100)
    levels = patch_levels(subject.draw(scene, CAMERA, FROM_ABOVE), [below, beside])
    assert (levels[0] < 0.7 * levels[1]) == subject.renderer.capabilities.shadows


def test_only_a_backend_that_declares_it_lets_surfaces_light_each_other(subject: Subject) -> None:
    """A red wall beside a white one, and a lamp that shines on the red one alone."""
    materials = {name: Material(name, color) for name, color in (("white", (0.8,) * 3), ("red", (0.8, 0.05, 0.05)))}
    models = [box_model("floor", (6, 6, 0.1), "white", "floor", 90), box_model("wall", (4, 0.1, 3), "red", "wall", 91)]
    placed = [("floor", at(0, 0, -0.05)), ("wall", at(0, 1.0, 1.5))]
    side = Light("spot", np.array([0.0, -2.5, 1.6]), np.array([0.0, 1.0, 0.0]), 9000.0, cone_inner=0.15, cone_outer=0.3)
    scene = make_scene(models, placed, [side], materials=materials, ambient=0.0, exposure=0.02)
    rgb = subject.draw(scene, CAMERA, level_camera(np.array([-3.0, -0.2, 2.5]), 0.2, -0.7)).rgb
    ids = subject.renderer.render(CAMERA, level_camera(np.array([-3.0, -0.2, 2.5]), 0.2, -0.7)).instance_ids
    floor = rgb[ids == 1].reshape(-1, 3).mean(axis=0)
    if subject.renderer.capabilities.global_illumination:
        assert floor[0] > 20.0
        assert floor[0] > 3.0 * floor[2]


def test_as_many_lamps_are_drawn_as_are_declared(subject: Subject) -> None:
    """Twenty lamps, each over a patch of floor of its own."""
    places = [(x, y) for x in (-6.0, -2.0, 2.0, 6.0) for y in (-8.0, -4.0, 0.0, 4.0, 8.0)]
    lamps = [replace(spot((x, y, 4.0), 2500.0), cone_inner=0.25, cone_outer=0.4) for x, y in places]
    scene = make_scene([FLOOR], [("floor", at(0, 0, -0.05))], lamps, ambient=0.0)
    buffers = subject.draw(scene, CAMERA, level_camera(np.array([0.0, 0.0, 20.0]), 0.0, -np.pi / 2))
    # Seen from above with the picture's top along +x and its right along -y.
    pixels = [(round(CAMERA.cx - 11.0 * y), round(CAMERA.cy - 11.0 * x)) for x, y in places]
    lit = int((patch_levels(buffers, pixels) > 40.0).sum())
    assert lit == min(len(lamps), subject.renderer.capabilities.max_lights or len(lamps))


def test_use_before_load_and_a_scene_that_cannot_be_drawn_are_refused(subject: Subject) -> None:
    scene = film_scene(None)
    broken = {
        "is of model 'ghost'": replace(scene, instances=(replace(scene.instances[0], model="ghost"),)),
        "has the material 'concrete'": replace(scene, materials={}),
        "object 1 occurs twice": replace(scene, instances=(scene.instances[0],) * 2),
        "nothing to draw": replace(scene, instances=()),
    }
    before = subject.draw(scene, OFF_CENTRE, AT_CARTON)
    for message, bad in broken.items():
        with pytest.raises(RenderError, match=message):
            subject.renderer.load(bad)
    after = subject.renderer.render(OFF_CENTRE, AT_CARTON)
    assert np.array_equal(before.instance_ids, after.instance_ids)
    assert np.array_equal(before.rgb, after.rgb)


def test_the_same_view_again_gives_the_same_bytes(subject: Subject) -> None:
    seen = view("off-centre")
    first = subject.draw(seen.scene, seen.camera, seen.T_world_camera)
    subject.renderer.render(CAMERA, seen.T_world_camera)
    again = subject.renderer.render(seen.camera, seen.T_world_camera)
    for channel in ("rgb", "depth", "instance_ids"):
        assert np.array_equal(getattr(first, channel), getattr(again, channel))


def test_the_description_names_what_draws(subject: Subject) -> None:
    words = subject.renderer.description
    assert subject.name in words.split(" on ")[0]
    assert any(character.isdigit() for character in words)
