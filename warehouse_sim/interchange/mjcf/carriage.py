"""A fork carriage on its mast before a pallet: drives, tilts, lifts and shifts aside on joints of its own."""

from dataclasses import dataclass, replace
from typing import Annotated
from xml.etree.ElementTree import Element

import numpy as np

from warehouse_sim.catalog.parts import solid_box
from warehouse_sim.catalog.traffic.truck_pieces import (
    FORK_LENGTH,
    FORK_SPREAD,
    FORK_THICKNESS,
    FORK_WIDTH,
    Mast,
    carriage,
    fork_pair,
    mast,
)
from warehouse_sim.errors import InputError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.interchange.mjcf.assets import MjcfAssets
from warehouse_sim.interchange.mjcf.bodies import COLLISION
from warehouse_sim.interchange.mjcf.xml import add, frame
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.render.painted_mesh import painted_meshes
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import Material, ObjectInstance, ObjectModel, Part, Pocket, SceneSpec

_BESIDE = 0.02
"""Room (m) beside each of two tines that share one pocket."""


@dataclass(frozen=True, eq=False)
class Approach:
    """One side of a pallet, and where the tines must be to enter it."""

    face: str
    T_object_dock: Transform
    """Origin at the middle of the openings, x inwards, z up."""
    T_world_floor: Transform
    """Below that origin on the floor (z = 0): level, x inwards."""
    height: float
    """Of the middle of the openings above the floor (m)."""
    spread: float
    """Between the middles of the tines (m)."""
    clear_width: float
    """For each tine (m)."""
    clear_height: float

    @classmethod
    def of(cls, scene: SceneSpec, item: ObjectInstance) -> "list[Approach]":
        """Return the sides of ``item`` that have pockets, the one that a viewpoint is nearest to first."""
        sides: dict[str, list[Pocket]] = {}
        for pocket in scene.model_of(item).pockets:
            sides.setdefault(pocket.face, []).append(pocket)
        eyes = [view.T_world_camera[:3, 3] for view in scene.viewpoints] or [np.zeros(3)]

        def nearness(way: "Approach") -> float:
            before = way.T_world_floor[:3, 3] - 2.0 * way.T_world_floor[:3, 0]
            return min(float(np.linalg.norm((eye - before)[:2])) for eye in eyes)

        return sorted((cls._side(item, face, pockets) for face, pockets in sides.items()), key=nearness)

    @classmethod
    def _side(cls, item: ObjectInstance, face: str, pockets: list[Pocket]) -> "Approach":
        rotation = pockets[0].T_object_pocket[:3, :3]
        places = np.array([pocket.T_object_pocket[:3, 3] for pocket in pockets])
        across = places @ rotation[:, 1]
        outer = pockets[int(across.argmin())], pockets[int(across.argmax())]
        spread, width = float(np.ptp(across)), min(float(pocket.size[1]) for pocket in outer)
        if len(pockets) == 1:  # two tines in one opening
            spread = min(FORK_SPREAD, width - FORK_WIDTH - 2 * _BESIDE)
            width = width / 2 if spread > FORK_WIDTH else 0.0
        middle = (outer[0].T_object_pocket[:3, 3] + outer[1].T_object_pocket[:3, 3]) / 2
        T_object_dock = make_transform(rotation, middle)
        T_world_dock = item.T_world_object @ T_object_dock
        forward, (x, y, z) = T_world_dock[:3, 0], T_world_dock[:3, 3]
        level = make_transform(rotation_z(float(np.arctan2(forward[1], forward[0]))), np.array([x, y, 0.0]))
        clear_height = min(float(pocket.size[2]) for pocket in outer)
        return cls(face, T_object_dock, level, float(z), spread, width, clear_height)


_WIDTH = 1.0
"""Of the carriage (m), as the catalog's counterbalance truck has it."""
_MAST_HEIGHT, _MAST_WIDTH, _MAST_FRONT = 2.15, 0.74, -0.11
"""Of the catalog's counterbalance truck (m); a taller mast where the pallet stands higher."""
_DEEP, _FOOT = 0.05, 0.1
"""Where the mast turns: behind its front, and above the floor (m)."""
_STEEL = 7850.0
"""Density of the forks (kg/m^3)."""
_MASSES = {"truck": 2500.0, "mast": 500.0, "lift": 120.0}
"""Kilograms of what drives, tilts and lifts: of the order of a 1.6 t truck's. They have no source."""
_DRIVE = (-1.0, 3.0)
_TILT = (-np.deg2rad(5.0), np.deg2rad(8.0))
_RISE, _LOWEST = 2.0, 0.005
_SHIFT = 0.1
"""Ranges of the joints (m, rad; tilt > 0 leans back), usual ones of 1.6 t trucks; they have no source."""
_GAIN, _TURN_GAIN = 1e6, 5e6
"""Stiffness of the position servos (N/m, Nm/rad): 500 kg on the forks lower them by 5 mm."""


@dataclass(frozen=True)
@ranged
class Carriage:
    """Where a fork carriage stands: level, square to a face of a pallet, tines at the height of its pockets."""

    pallet: Annotated[int, Range(1, 1_000_000_000)]
    """Instance id of an object with pockets."""
    face: str | None = None
    """Side of it, "-x", "+x", "-y" or "+y"; None = the one with room that a viewpoint is nearest to."""
    distance: Annotated[float, Range(0.01, 20, "m")] = 0.5
    """From the tips of the tines to the face (m), 0.01-20."""


def add_carriage(
    root: Element, world: Element, bodies: dict[int, Element], scene: SceneSpec, place: Carriage, assets: MjcfAssets
) -> None:
    """Add the bodies, joints, servos and sensors of a carriage.

    Bodies: ``carriage_truck`` (slides along x) > ``carriage_mast`` (tilts) > ``carriage_lift`` (slides along z) >
    ``carriage_forks`` (slides along y). Sites: ``carriage_tips`` between the tips, ``carriage_dock`` at the middle of
    the pallet's openings. Joints and servos are called ``drive``, ``tilt``, ``lift`` and ``side_shift``.

    Raises:
        InputError: There is no such pallet or face, its pockets are too small, or there is no room.
    """
    way = chosen_approach(scene, place)
    top = way.height + FORK_THICKNESS / 2
    low = min(_LOWEST + FORK_THICKNESS - top, 0.0)
    tilting, forks = _add_bodies(world, _truck_pose(way, place), top, low)
    for number, box in enumerate(_solids(way.spread)):
        geom = {"type": "box", "size": box.size / 2, "density": _STEEL, **frame(box.T_parent_box)}
        add(forks, "geom", name=f"carriage:{number}", group=COLLISION, **geom)
    height = max(_MAST_HEIGHT, top + 1.2)
    _look(tilting, "mast", mast(Mast(height, _MAST_WIDTH, _DEEP, 2)), assets, -_FOOT)
    _look(forks, "forks", [*_apart(fork_pair(0.0), way.spread), *carriage(0.0, _WIDTH)], assets)
    add(forks, "site", name="carriage_tips", pos=[FORK_LENGTH, 0.0, -FORK_THICKNESS / 2])
    add(bodies[place.pallet], "site", name="carriage_dock", **frame(way.T_object_dock))
    _add_servos(root, low)


def _add_bodies(world: Element, T_world_truck: Transform, top: float, low: float) -> tuple[Element, Element]:
    """Add the four bodies with their joints; return that of the mast and that of the forks.

    Args:
        world: What they are part of.
        T_world_truck: Origin below the heels of the tines.
        top: Height of the tines' upper sides (m), from which ``lift`` counts.
        low: Least value of ``lift`` (m).
    """
    truck = _body(world, "truck", T_world_truck)
    add(truck, "joint", name="drive", type="slide", axis=[1, 0, 0], range=_DRIVE)
    tilting = _body(truck, "mast", make_transform(None, np.array([_MAST_FRONT - _DEEP, 0.0, _FOOT])))
    add(tilting, "joint", name="tilt", type="hinge", axis=[0, -1, 0], range=_TILT)
    lifting = _body(tilting, "lift", make_transform(None, np.array([_DEEP - _MAST_FRONT, 0.0, top - _FOOT])))
    add(lifting, "joint", name="lift", type="slide", axis=[0, 0, 1], range=[low, _RISE])
    forks = _body(lifting, "forks", np.eye(4))
    add(forks, "joint", name="side_shift", type="slide", axis=[0, 1, 0], range=[-_SHIFT, _SHIFT])
    for body, name in ((truck, "truck"), (tilting, "mast"), (lifting, "lift")):
        # Weight only: what of them could touch the pallet is part of the forks' body.
        add(body, "inertial", pos=[0.0, 0.0, 0.0], mass=_MASSES[name], diaginertia=[_MASSES[name] * 0.2] * 3)
    return tilting, forks


def chosen_approach(scene: SceneSpec, place: Carriage) -> Approach:
    """Return how the carriage stands to its pallet.

    Raises:
        InputError: There is no such pallet or face, its pockets are too small, or there is no room.
    """
    item = next((one for one in scene.instances if one.instance_id == place.pallet), None)
    known = [one.instance_id for one in scene.instances if scene.model_of(one).pockets]
    if item is None or not scene.model_of(item).pockets:
        listed = ", ".join(map(str, known[:20])) or "none"
        raise InputError(f"carriage: object {place.pallet} has no pockets or is not there; known: {listed}")
    ways = Approach.of(scene, item)
    names = [way.face for way in ways]
    if place.face is not None and place.face not in names:
        raise InputError(
            f"carriage: face {place.face!r} of object {place.pallet} has no pockets; known: {', '.join(names)}"
        )
    solids, problems = Solids.of(scene.instances, scene.models), []
    for way in ways:
        if place.face in (None, way.face):
            problem = _problem(way, place, solids)
            if problem is None:
                return way
            problems.append(f"{way.face} {problem}")
    raise InputError(
        f"carriage: no way into object {place.pallet} from {place.distance:g} m: {'; '.join(problems)}; "
        "choose another pallet, face or distance"
    )


def _problem(way: Approach, place: Carriage, solids: Solids) -> str | None:
    if way.clear_width < FORK_WIDTH or way.clear_height < FORK_THICKNESS:
        size = f"{1000 * way.clear_width:.0f} x {1000 * way.clear_height:.0f} mm"
        return f"has pockets of {size}, too small for the tines"
    lift = make_transform(None, np.array([0.0, 0.0, way.height + FORK_THICKNESS / 2]))
    T_world_forks = _truck_pose(way, place) @ lift
    boxes = [box.placed(T_world_forks) for box in _solids(way.spread)]
    return "has no room before it" if min(solids.gap(box, 0.1) for box in boxes) <= 0.0 else None


def _truck_pose(way: Approach, place: Carriage) -> Transform:
    """Return the pose of the truck, origin on the floor (z = 0) below the heels of the tines."""
    return way.T_world_floor @ make_transform(None, np.array([-place.distance - FORK_LENGTH, 0.0, 0.0]))


def _solids(spread: float) -> list[OrientedBox]:
    """Return what of the carriage touches: blades, shanks and the plate behind, with z = 0 at the blades' top."""
    found, length = [], FORK_LENGTH + FORK_THICKNESS
    for y in (-spread / 2, spread / 2):
        blade = (length, FORK_WIDTH, FORK_THICKNESS)
        found.append(solid_box(blade, (length / 2 - FORK_THICKNESS, y, -FORK_THICKNESS / 2)))
        found.append(solid_box((FORK_THICKNESS, FORK_WIDTH, 0.56), (-FORK_THICKNESS / 2, y, 0.28)))
    return [*found, solid_box((0.01, _WIDTH, 1.0), (-FORK_THICKNESS - 0.02, 0.0, 0.66))]


def _apart(forks: list[Part], spread: float) -> list[Part]:
    """Return the right and the left fork of ``fork_pair`` with their middles ``spread`` (m) apart."""
    moved = []
    for fork, side in zip(forks, (-1.0, 1.0), strict=True):
        aside = make_transform(None, np.array([0.0, side * (spread - FORK_SPREAD) / 2, 0.0]))
        moved.append(replace(fork, T_object_part=aside @ fork.T_object_part))
    return moved


def _body(parent: Element, name: str, T: Transform) -> Element:
    return add(parent, "body", name=f"carriage_{name}", gravcomp=1, **frame(T))


def _look(body: Element, name: str, parts: list[Part], assets: MjcfAssets, lowered: float = 0.0) -> None:
    materials: dict[str, Material] = assets.of_catalog({part.material for part in parts})
    model = ObjectModel(name, "forklift", 1, np.ones(3), tuple(parts), ())
    for number, (material, mesh) in enumerate(painted_meshes(model, materials).items()):
        made = assets.mesh(f"carriage_{name}:{number}", mesh)
        if made is not None:
            color = assets.material(material)
            add(body, "geom", class_="visual", type="mesh", mesh=made, material=color, pos=[0.0, 0.0, lowered])


def _add_servos(root: Element, low: float) -> None:
    servos = {
        "drive": (_DRIVE, _GAIN, 20_000.0),
        "tilt": (_TILT, _TURN_GAIN, 100_000.0),
        "lift": ((low, _RISE), _GAIN, 40_000.0),
        "side_shift": ((-_SHIFT, _SHIFT), _GAIN, 10_000.0),
    }
    section, sensors = add(root, "actuator"), add(root, "sensor")
    for name, (span, gain, most) in servos.items():
        limits = {"ctrlrange": span, "forcerange": [-most, most]}
        add(section, "position", name=name, joint=name, kp=gain, dampratio=1, **limits)
        add(sensors, "jointpos", name=f"{name}_position", joint=name)
        add(sensors, "actuatorfrc", name=f"{name}_force", actuator=name)
    ends = {"objtype": "site", "objname": "carriage_tips", "reftype": "site", "refname": "carriage_dock"}
    add(sensors, "framepos", name="tips_in_dock", **ends)
