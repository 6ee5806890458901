"""Objects as bodies: mass, friction and boxes are those that physics settled them with, and meshes show them."""

from xml.etree.ElementTree import Element

import mujoco

from warehouse_sim.geometry.pose import invert, make_transform, matrix_from_quat_wxyz
from warehouse_sim.interchange.mjcf.assets import MjcfAssets
from warehouse_sim.interchange.mjcf.xml import add, frame
from warehouse_sim.render.painted_mesh import painted_meshes
from warehouse_sim.schema import ObjectInstance, SceneSpec

FILM, VISUAL, COLLISION = 1, 2, 3
"""Groups of geoms: clear film, what else is seen, and the boxes that touch, which viewers hide at first."""


def add_settings(root: Element, physics: mujoco.MjSpec) -> None:
    """Add step, memory and contacts of ``physics``, and the class of geoms that are only seen."""
    geom = physics.default.geom
    add(root, "option", timestep=physics.option.timestep, integrator="implicitfast")
    add(root, "size", memory=f"{physics.memory >> 20}M")
    defaults = add(root, "default")
    add(defaults, "geom", solref=geom.solref, solimp=geom.solimp, friction=geom.friction, group=COLLISION)
    add(add(defaults, "default", class_="visual"), "geom", contype=0, conaffinity=0, mass=0, group=VISUAL)


def add_objects(world: Element, scene: SceneSpec, physics: mujoco.MjSpec, assets: MjcfAssets) -> dict[int, Element]:
    """Add a body for each object, named by its instance id; return them.

    What belongs to a unit load but neither moves by itself nor touches anything, such as film, moves with its pallet.

    Args:
        world: Element of the world's body.
        scene: The objects.
        physics: The same scene as ``to_mjspec`` returns it.
        assets: Where meshes and materials go.
    """
    bodies: dict[int, Element] = {}
    pallets: dict[int, ObjectInstance] = {}
    for item in scene.instances:
        if item.dynamic and item.group:
            pallets.setdefault(item.group, item)  # the first piece of a load, which film follows as it settles
    looks: dict[object, int] = {}
    for item in sorted(scene.instances, key=lambda one: not one.dynamic):
        carrier = None if item.dynamic or scene.model_of(item).collision else pallets.get(item.group)
        parent = world if carrier is None else bodies[carrier.instance_id]
        T_parent = item.T_world_object if carrier is None else invert(carrier.T_world_object) @ item.T_world_object
        body = add(parent, "body", name=str(item.instance_id), **frame(T_parent))
        if item.dynamic:
            add(body, "freejoint", name=str(item.instance_id))
        _add_boxes(body, physics.body(str(item.instance_id)))
        _add_look(body, scene, item, assets, looks.setdefault(item.look, len(looks)))
        bodies[item.instance_id] = body
    return bodies


def _add_boxes(body: Element, built: mujoco.MjsBody) -> None:
    for geom in built.geoms:
        T = make_transform(matrix_from_quat_wxyz(geom.quat), geom.pos)
        add(body, "geom", name=geom.name, type="box", size=geom.size, mass=geom.mass, **frame(T))


def _add_look(body: Element, scene: SceneSpec, item: ObjectInstance, assets: MjcfAssets, look: int) -> None:
    """Add a visual geom for each material; a mesh is there once for all objects of one look."""
    painted = painted_meshes(scene.painted_model_of(item), scene.materials)
    for number, (material, mesh) in enumerate(painted.items()):
        name = assets.mesh(f"{item.model}:{look}:{number}", mesh)
        if name is None:
            continue
        film = {"group": FILM, "castshadow": False} if scene.materials[material].opacity < 1.0 else {}
        add(body, "geom", class_="visual", type="mesh", mesh=name, material=assets.material(material), **film)
