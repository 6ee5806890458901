"""A whole scene as MJCF: bodies as physics has them, what they look like, light and cameras."""

import json
from pathlib import Path
from xml.etree.ElementTree import Element, indent, tostring

import mujoco
import numpy as np

from warehouse_sim.color import srgb_from_linear
from warehouse_sim.errors import OutputError
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.interchange.mjcf.assets import MjcfAssets
from warehouse_sim.interchange.mjcf.bodies import add_objects, add_settings
from warehouse_sim.interchange.mjcf.carriage import Carriage, add_carriage, chosen_approach
from warehouse_sim.interchange.mjcf.xml import add, frame
from warehouse_sim.interchange.rig_cameras import RigCamera, rig_cameras
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.physics.build import to_mjspec
from warehouse_sim.render.light_selection import reference_points, strongest_lights
from warehouse_sim.render.mujoco.model import MAX_LIGHTS, Level, add_background, add_light, measure_level
from warehouse_sim.render.painted_mesh import require_renderable
from warehouse_sim.scene.lighting.photometry import as_cone
from warehouse_sim.schema import Light, SceneSpec
from warehouse_sim.sensors.rig import RigConfig


def write_mjcf(scene: SceneSpec, path: Path, rig: RigConfig | None = None, carriage: Carriage | None = None) -> Path:
    """Write ``scene`` to ``path`` (.xml), and its meshes and textures into a folder of the file's name beside it.

    ``write_mjcf(prepared.scene, Path("scene.xml"), recipe.sensors)`` writes what ``prepare_scene`` returned. Masses,
    friction, contacts and collision boxes are those that the scene was settled with, so that a settled scene stays.

    Args:
        scene: Lit, and settled where it shall stand still.
        path: File to write.
        rig: Whose cameras stand at the viewpoints; None = no cameras.
        carriage: A fork carriage before one of the pallets; None = none.

    Raises:
        MissingPackageError: MuJoCo is not installed.
        RenderError: The scene is empty, or an object of it cannot be drawn.
        InputError: There is no such pallet for the carriage, or no room before it.
        OutputError: The files cannot be written.
    """
    if path.suffix != ".xml":
        raise OutputError(f"{path}: MJCF cannot be written there; choose a name that ends with .xml")
    require_renderable(scene)
    if carriage is not None:
        chosen_approach(scene, carriage)  # what cannot be is rejected before anything is written
    folder = path.with_suffix("")
    make_folder(folder)
    physics, level, cameras = to_mjspec(scene), level_of(scene), rig_cameras(scene, rig)
    root = Element("mujoco", model=f"scene_{scene.scene_index:06d}")
    add(root, "compiler", angle="radian", meshdir=folder.name, texturedir=folder.name)
    add_settings(root, physics)
    add_visual(root, level, cameras)
    _add_facts(root, scene, cameras)
    section = add(root, "asset")
    add_sky(section, scene)
    assets, world = MjcfAssets(section, scene, level, folder), add(root, "worldbody")
    add_lights(world, scene, level)
    add_cameras(world, cameras)
    bodies = add_objects(world, scene, physics, assets)
    if carriage is not None:
        add_carriage(root, world, bodies, scene, carriage, assets)
    indent(root)
    write_bytes(path, tostring(root, encoding="utf-8") + b"\n")
    return path


def _add_facts(root: Element, scene: SceneSpec, cameras: list[RigCamera]) -> None:
    """Add what MJCF has no place for as JSON texts: what the bodies are, the cameras in full, light and exposure."""
    objects = {}
    for item in scene.instances:
        model = scene.model_of(item)
        objects[str(item.instance_id)] = [model.class_name, model.obj_id, item.model, item.group]
    facts = {
        "objects": {"columns": ["class_name", "obj_id", "model", "group"], **objects},
        "cameras": {item.name: item.to_plain() for item in cameras},
        "scene": {
            "scene_index": scene.scene_index,
            "seed": scene.seed,
            "lighting": scene.lighting,
            "ambient_lux": scene.ambient,
            "exposure": scene.exposure,
        },
    }
    section = add(root, "custom")
    for name, value in facts.items():
        add(section, "text", name=name, data=json.dumps(value, separators=(",", ":"), allow_nan=False))


_PIXEL = 1e-5
"""Edge of a pixel (m): MJCF states focal lengths on a sensor; only ratios are seen."""
_EXTENT, _NEAR, _FAR = 10.0, 0.05, 1000.0
"""Size of a scene that clipping planes are fractions of, and these planes (m)."""
_SHADOW_PX = 2048
_LEAST_PX = (640, 480)


def shown_lights(scene: SceneSpec) -> list[Light]:
    """Return the lights that are on: as many as fixed-function OpenGL has, the strongest where the rig looks."""
    return strongest_lights(scene.lights, MAX_LIGHTS, reference_points(scene))


def level_of(scene: SceneSpec) -> Level:
    """Return how the scene's light is turned into display values."""
    return measure_level(scene, [as_cone(light) for light in shown_lights(scene)])


def add_visual(root: Element, level: Level, cameras: list[RigCamera]) -> None:
    """Add even light, clipping planes and sizes of images and shadow maps."""
    width, height = np.max([_LEAST_PX, *((item.camera.width, item.camera.height) for item in cameras)], axis=0)
    add(root, "statistic", extent=_EXTENT)
    visual = add(root, "visual")
    add(visual, "global", offwidth=width, offheight=height)
    add(visual, "quality", shadowsize=_SHADOW_PX)
    add(visual, "headlight", ambient=[level.even] * 3, diffuse=[0.0] * 3, specular=[0.0] * 3)
    add(visual, "map", znear=_NEAR / _EXTENT, zfar=_FAR / _EXTENT, shadowscale=1.0)


def add_sky(assets: Element, scene: SceneSpec) -> None:
    """Add what is seen where nothing stands."""
    sampled = mujoco.MjSpec()
    add_background(sampled, scene)
    (sky,) = sampled.textures
    size = {"width": sky.width, "height": sky.height}
    add(assets, "texture", name="background", type="skybox", builtin="flat", rgb1=sky.rgb1, rgb2=sky.rgb2, **size)


def add_lights(world: Element, scene: SceneSpec, level: Level) -> None:
    """Add all lights of the hall; those beyond the strongest are there but off, for renderers that bear more."""
    shown = shown_lights(scene)
    fractions = {id(light): float(value) for light, value in zip(shown, level.lights, strict=True)}
    for number, light in enumerate([*shown, *(light for light in scene.lights if id(light) not in fractions)]):
        sampled, cone = mujoco.MjSpec(), as_cone(light)
        active = id(light) in fractions
        add_light(sampled, cone, fractions.get(id(light), 0.0), light.casts_shadow and light.kind == "spot")
        (item,) = sampled.worldbody.lights
        add(
            world,
            "light",
            name=f"light_{number:03d}",
            active=active,
            type="spot",
            pos=item.pos,
            dir=item.dir,
            diffuse=item.diffuse if active else srgb_from_linear(np.array(light.color) / max(light.color)),
            specular=item.specular,
            ambient=item.ambient,
            attenuation=item.attenuation,
            cutoff=item.cutoff,
            exponent=item.exponent,
            castshadow=bool(item.castshadow),
            bulbradius=light.radius,
            intensity=cone.intensity,
        )


def add_cameras(world: Element, cameras: list[RigCamera]) -> None:
    """Add the rig's cameras, with principal points that may lie anywhere; MJCF knows no lens."""
    for item in cameras:
        camera = item.camera
        # What MuJoCo takes is how far the image's middle, at (width - 1) / 2, lies right of and below the optical axis.
        aside = (camera.width - 1) / 2 - camera.cx, (camera.height - 1) / 2 - camera.cy
        T = item.T_world_camera @ make_transform(np.diag([1.0, -1.0, -1.0]))
        add(
            world,
            "camera",
            name=item.name,
            **frame(T),
            resolution=[camera.width, camera.height],
            focalpixel=[camera.fx, camera.fy],
            principalpixel=aside,
            sensorsize=[_PIXEL * camera.width, _PIXEL * camera.height],
        )
