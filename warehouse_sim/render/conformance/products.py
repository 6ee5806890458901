"""What a backend declares it does, and what it does not declare it rejects or leaves out: nothing is faked."""

from dataclasses import replace

import cv2
import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene, spot
from warehouse_sim.render.conformance.subject import OFF_CENTRE, Subject, cast_image, view
from warehouse_sim.render.renderer import AmodalMask
from warehouse_sim.schema import Light, Material, RenderBuffers, SceneSpec

_CAMERA = PinholeCamera.from_focal(320, 200, 220.0)
_FROM_ABOVE = level_camera(np.array([0.0, 0.0, 6.0]), 0.0, -np.pi / 2)
_AT_CARTON = level_camera(np.array([-3.0, 0.0, 1.2]), 0.0, -0.25)
_FLOOR = box_model("floor", (40, 40, 0.1), "concrete", "floor", 90)


def check_normals(subject: Subject) -> None:
    """Expect normals where they are declared and requested, else a rejection."""
    seen = view("off-centre")
    subject.renderer.load(seen.scene)
    if not subject.renderer.capabilities.normals:
        subject.expect_cannot(
            lambda: subject.renderer.render(seen.camera, seen.T_world_camera, normals=True), "normals"
        )
    else:
        normals = subject.renderer.render(seen.camera, seen.T_world_camera, normals=True).normals
        subject.expect(normals is not None, "it declares normals and returns none")
    plain = subject.renderer.render(seen.camera, seen.T_world_camera)
    subject.expect(plain.normals is None, "normals that nobody requested")


def check_amodal_masks(subject: Subject) -> None:
    """Compare amodal masks, also beyond the image, with rays at the object alone."""
    scene, camera = view("off-centre").scene, PinholeCamera(150, 100, 125.0, 120.0, 70.0, 45.0)
    T, pallets = scene.viewpoints[2].T_world_camera, scene.target_instances()
    subject.renderer.load(scene)
    if not subject.renderer.capabilities.amodal_masks:
        subject.expect_cannot(lambda: subject.renderer.amodal_masks(camera, T, pallets), "amodal masks")
        return
    found = subject.renderer.amodal_masks(camera, T, pallets)
    instance_mask = subject.renderer.render(camera, T).instance_mask
    for before, after in zip(found, subject.renderer.amodal_masks(camera, T, pallets), strict=True):
        same = before.offset == after.offset and np.array_equal(before.mask, after.mask)
        subject.expect(same, "amodal masks differ before and after an image")
    wide = camera.crop(-camera.width, -camera.height, 3 * camera.width, 3 * camera.height)
    for pallet, amodal_mask in zip(pallets, found, strict=True):
        exact = cast_image(replace(scene, instances=(pallet,)), wide, T).instance_mask > 0
        sampled, who = _on_canvas(amodal_mask, camera), f"object {pallet.instance_id}"
        rim = cv2.morphologyEx(exact.astype(np.uint8), cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8)) > 0
        subject.expect((sampled == exact)[~rim].all(), f"the amodal mask of {who} is wrong beside its outline")
        wrong, allowed = np.count_nonzero(sampled != exact), 2 + 0.02 * np.count_nonzero(rim)
        subject.expect(wrong <= allowed, f"{wrong} pixels of the amodal mask of {who} are wrong")
        image = sampled[camera.height : 2 * camera.height, camera.width : 2 * camera.width]
        visible = instance_mask == pallet.instance_id
        subject.expect(not (visible & ~image).any(), f"{who} is visible outside of its amodal mask")


def check_film(subject: Subject) -> None:
    """Expect film to tint the image, or to be left out, and never to touch depth, instance masks and shadows."""
    bare, wrapped = (
        subject.render(_film_scene(film), _CAMERA, _AT_CARTON)
        for film in (None, Material("film", (0.9,) * 3, opacity=0.5))
    )
    subject.expect(np.array_equal(bare.instance_mask, wrapped.instance_mask), "film changes the instance mask")
    subject.expect(np.array_equal(bare.depth, wrapped.depth), "film changes depth")
    if not subject.renderer.capabilities.film:
        subject.expect(np.array_equal(bare.rgb, wrapped.rgb), "film is not declared, but changes colours")
        return
    # Means over many pixels, in which a path tracer's noise is small.
    change = np.abs(cv2.blur(wrapped.rgb.astype(np.float32) - bare.rgb, (11, 11))).max(axis=2)
    subject.expect(np.median(change[wrapped.instance_mask == 2]) > 8, "film is declared, but changes no colour")
    # It casts no shadow: what it changes of the floor is its own outline.
    subject.expect((change[wrapped.instance_mask == 1] > 12).mean() < 0.05, "film shades the floor")


def check_paint(subject: Subject) -> None:
    """Expect an object's own paint in the image, and nothing else changed; film is no paint for board."""
    models = [_FLOOR, box_model("carton", (0.6, 0.6, 0.6))]
    placed = [("floor", at(0, 0, -0.05)), ("carton", at(0, 0, 0.3)), ("carton", at(0, 0.9, 0.3))]
    blue, film = Material("blue", (0.02, 0.05, 0.6)), Material("film", (0.5,) * 3, opacity=0.5)
    light = spot((-2.0, 1.0, 3.5), 2500.0)
    bare = make_scene(models, placed, [light], materials={**MATERIALS, "blue": blue, "film": film}, ambient=60.0)

    def painted(number: int, paint: dict[str, str]) -> SceneSpec:
        instances = [replace(item, paint=paint) if item.instance_id == number else item for item in bare.instances]
        return replace(bare, instances=tuple(instances))

    before = subject.render(bare, _CAMERA, _AT_CARTON)
    for number, other in ((2, 3), (3, 2)):
        after = subject.render(painted(number, {"kraft": "blue"}), _CAMERA, _AT_CARTON)
        subject.expect(np.array_equal(before.instance_mask, after.instance_mask), "paint changes the instance mask")
        subject.expect(np.array_equal(before.depth, after.depth), "paint changes depth")
        own, beside = (after.rgb[after.instance_mask == key].reshape(-1, 3).mean(axis=0) for key in (number, other))
        subject.expect(own[2] > 1.5 * own[0], f"an object painted blue has the colour {own}")
        subject.expect(beside[0] > 1.2 * beside[2], f"an object beside one that is painted has the colour {beside}")
    for paint, message in (({"kraft": "film"}, "film must stay film"), ({"kraft": "ghost"}, "the material 'ghost'")):
        subject.expect_rejection(lambda paint=paint: subject.renderer.load(painted(2, paint)), message)  # type: ignore[misc]


def check_textures(subject: Subject) -> None:
    """Expect textures to structure what is plain without them, where they are declared."""
    spread = {}
    for texture in (None, "concrete"):
        materials = {**MATERIALS, "concrete": replace(MATERIALS["concrete"], texture=texture, texture_size=3.0)}
        lights = [spot((0.0, 0.0, 7.0), 6000.0)]
        scene = make_scene([_FLOOR], [("floor", at(0, 0, -0.05))], lights, materials=materials, ambient=200.0)
        rgb = subject.render(scene, _CAMERA, _FROM_ABOVE).rgb[40:160, 80:240].astype(np.float32)
        fine = cv2.blur(rgb, (9, 9)) - cv2.blur(rgb, (61, 61))
        spread[texture] = float(fine.std())
    found = spread["concrete"] > spread[None] + 0.5
    declared = subject.renderer.capabilities.textures
    subject.expect(found == declared, f"textures: declared {declared}, found {found}")


def check_shadows(subject: Subject) -> None:
    """Expect the shadow of a table under a light where shadows are declared."""
    models = [_FLOOR, box_model("table", (1.2, 1.2, 0.05))]
    placed = [("floor", at(0, 0, -0.05)), ("table", at(0.0, 0.0, 1.5))]
    scene = make_scene(models, placed, [spot((0.0, 3.0, 5.0), 6000.0)], ambient=40.0)
    # The light's rays over the middle of the table reach the floor at y = 3 - 3 * 5 / 3.5: right in the image.
    below, beside = (160 + round(220 / 6 * 1.29), 100), (160 - round(220 / 6 * 1.29), 100)
    levels = _patch_levels(subject.render(scene, _CAMERA, _FROM_ABOVE), [below, beside])
    found, declared = bool(levels[0] < 0.7 * levels[1]), subject.renderer.capabilities.shadows
    subject.expect(found == declared, f"shadows: declared {declared}, found {found}")


def check_global_illumination(subject: Subject) -> None:
    """Expect the floor before a red wall that alone is lit to be red, where global illumination is declared."""
    materials = {name: Material(name, color) for name, color in (("white", (0.8,) * 3), ("red", (0.8, 0.05, 0.05)))}
    models = [box_model("floor", (6, 6, 0.1), "white", "floor", 90), box_model("wall", (4, 0.1, 3), "red", "wall", 91)]
    placed = [("floor", at(0, 0, -0.05)), ("wall", at(0, 1.0, 1.5))]
    side = Light("spot", np.array([0.0, -2.5, 1.6]), np.array([0.0, 1.0, 0.0]), 9000.0, cone_inner=0.15, cone_outer=0.3)
    scene = make_scene(models, placed, [side], materials=materials, ambient=0.0, exposure=0.02)
    sampled = subject.render(scene, _CAMERA, level_camera(np.array([-3.0, -0.2, 2.5]), 0.2, -0.7))
    floor = sampled.rgb[sampled.instance_mask == 1].reshape(-1, 3).mean(axis=0)
    if subject.renderer.capabilities.global_illumination:
        subject.expect(floor[0] > 20.0 and floor[0] > 3.0 * floor[2], f"the wall's light gives the floor {floor}")


def check_lights(subject: Subject) -> None:
    """Expect as many of twenty lights, each over a patch of floor of its own, as are declared."""
    places = [(x, y) for x in (-6.0, -2.0, 2.0, 6.0) for y in (-8.0, -4.0, 0.0, 4.0, 8.0)]
    lights = [replace(spot((x, y, 4.0), 2500.0), cone_inner=0.25, cone_outer=0.4) for x, y in places]
    scene = make_scene([_FLOOR], [("floor", at(0, 0, -0.05))], lights, ambient=0.0)
    buffers = subject.render(scene, _CAMERA, level_camera(np.array([0.0, 0.0, 20.0]), 0.0, -np.pi / 2))
    # Seen from above with the image's top along +x and its right along -y; beside each patch no light shines.
    pixels = [(round(_CAMERA.cx - 11.0 * y), round(_CAMERA.cy - 11.0 * x)) for x, y in places]
    beside = [(u, v + 22) for u, v in pixels]
    brighter = _patch_levels(buffers, pixels) - _patch_levels(buffers, beside)
    lit, most = int((brighter > 30.0).sum()), subject.renderer.capabilities.max_lights
    wanted = len(lights) if most is None else min(len(lights), most)
    subject.expect(lit == wanted, f"{lit} of {len(lights)} lights are rendered, {wanted} are declared")


def check_broken_scenes(subject: Subject) -> None:
    """Expect scenes that cannot be rendered to be rejected, and the one before to stay."""
    scene = _film_scene(None)
    broken = {
        "is of model 'ghost'": replace(scene, instances=(replace(scene.instances[0], model="ghost"),)),
        "has the material 'concrete'": replace(scene, materials={}),
        "object 1 occurs twice": replace(scene, instances=(scene.instances[0],) * 2),
        "nothing to render": replace(scene, instances=()),
    }
    before = subject.render(scene, OFF_CENTRE, _AT_CARTON)
    for message, bad in broken.items():
        subject.expect_rejection(lambda bad=bad: subject.renderer.load(bad), message)  # type: ignore[misc]
    after = subject.renderer.render(OFF_CENTRE, _AT_CARTON)
    subject.expect(
        np.array_equal(before.instance_mask, after.instance_mask), "a rejected scene changes the instance mask"
    )
    subject.expect(np.array_equal(before.rgb, after.rgb), "a rejected scene changes colours")


def check_repetition(subject: Subject) -> None:
    """Expect a view to have the same bytes again, after others, and in a scene that has no other viewpoint."""
    seen = view("off-centre")
    first = subject.render(seen.scene, seen.camera, seen.T_world_camera)
    subject.renderer.render(_CAMERA, seen.T_world_camera)
    again = subject.renderer.render(seen.camera, seen.T_world_camera)
    alone = subject.render(replace(seen.scene, viewpoints=seen.scene.viewpoints[1:2]), seen.camera, seen.T_world_camera)
    for other, when in ((again, "when it is rendered again"), (alone, "without the scene's other viewpoints")):
        for channel in ("rgb", "depth", "instance_mask"):
            same = np.array_equal(getattr(first, channel), getattr(other, channel))
            subject.expect(same, f"the same view has another {channel} {when}")


def check_description(subject: Subject) -> None:
    """Expect the description to name the backend, and something with a number: versions."""
    words = subject.renderer.description
    subject.expect(subject.name in words.split(" on ")[0], f"the description {words!r} does not name the backend")
    subject.expect(any(character.isdigit() for character in words), f"the description {words!r} names no version")


def _patch_levels(buffers: RenderBuffers, pixels: list[tuple[int, int]]) -> np.ndarray:
    """Return the brightness around each of ``pixels`` (column, row)."""
    return np.array([buffers.rgb[v - 3 : v + 4, u - 3 : u + 4].mean() for u, v in pixels])


def _film_scene(material: Material | None) -> SceneSpec:
    """Return a carton on the floor before the camera, wrapped in ``material``."""
    models = [_FLOOR, box_model("carton", (0.6, 0.6, 0.6)), box_model("wrap", (0.62, 0.62, 0.62), "film", "wrap", 91)]
    placed = [("floor", at(0, 0, -0.05)), ("carton", at(0, 0, 0.3)), ("wrap", at(0, 0, 0.3))]
    film = material or Material("film", (0.5,) * 3)
    light = spot((-2.0, 1.0, 3.5), 2500.0)
    scene = make_scene(models, placed, [light], materials={**MATERIALS, "film": film}, ambient=60.0)
    return scene if material is not None else replace(scene, instances=scene.instances[:2])


def _on_canvas(amodal_mask: AmodalMask, camera: PinholeCamera) -> np.ndarray:
    """Return the amodal mask on the canvas of 3W x 3H with the image in the middle."""
    canvas = np.zeros((3 * camera.height, 3 * camera.width), bool)
    left, top = amodal_mask.offset[0] + camera.width, amodal_mask.offset[1] + camera.height
    height, width = amodal_mask.mask.shape
    canvas[top : top + height, left : left + width] = amodal_mask.mask
    return canvas
