"""A whole scene as MJCF: bodies as physics has them, what they look like, light and cameras."""

import json
from pathlib import Path
from xml.etree.ElementTree import Element, indent, tostring

from warehouse_sim.errors import OutputError
from warehouse_sim.interchange.mjcf.assets import MjcfAssets
from warehouse_sim.interchange.mjcf.bodies import add_objects, add_settings
from warehouse_sim.interchange.mjcf.carriage import Carriage, add_carriage, chosen_approach
from warehouse_sim.interchange.mjcf.light import add_cameras, add_lights, add_sky, add_visual, level_of
from warehouse_sim.interchange.mjcf.xml import add
from warehouse_sim.interchange.rig_cameras import RigCamera, rig_cameras
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.physics.build import to_mjspec
from warehouse_sim.render.painted_mesh import require_renderable
from warehouse_sim.schema import SceneSpec
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
