"""A station and a truck as one MuJoCo model."""

from collections.abc import Iterator

import mujoco
import numpy as np
from jaxtyping import Float
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError

from warehouse_sim.benchmark.docking.station import Station
from warehouse_sim.benchmark.docking.truck import TRUCK
from warehouse_sim.catalog.parts import solid_box
from warehouse_sim.evaluation.docking.fork import TINE_LENGTH, TINE_THICKNESS, TINE_WIDTH
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import (
    Transform,
    invert,
    make_transform,
    quat_wxyz_from_matrix,
    rotation_y,
    rotation_z,
    transform_points,
)
from warehouse_sim.physics.build import CONTACT_DAMPING, CONTACT_IMPEDANCE, CONTACT_TIME, FRICTION, TIME_STEP
from warehouse_sim.schema import ObjectModel

FORKS, PALLET, LOAD = "forks", "pallet", "load"
"""Names of the bodies."""
_SERVO = 1e7
"""Stiffness of drive and lift (N/m): a loaded pallet of 1 t lowers the forks by 1 mm. An assumption."""
_PIVOT = 0.10
"""Height of the bar about which the forks swing in their play over the blades' middle (m): an assumption."""
_HELD = 100.0
"""Friction in the sideshifter (N): 210 kg on greased bearings at 0.05, an assumption; it holds the forks in place."""
_PARALLEL = 1e-9


def build(station: Station, T_world_dock: Transform, tines: Float[np.ndarray, " t"]) -> mujoco.MjModel:
    """Return the model: fixed surroundings, a loose pallet board by board, its load as one body, and the truck.

    Args:
        station: Where the truck goes in.
        T_world_dock: The *estimated* dock frame: origin between the openings, x inwards. The truck stands level on its
            heading; its tines point along it.
        tines: Where the middles of the tines are along y of that frame (m).
    """
    spec = mujoco.MjSpec()
    spec.option.timestep = TIME_STEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.default.geom.solref = (CONTACT_TIME, CONTACT_DAMPING)
    spec.default.geom.solimp = CONTACT_IMPEDANCE
    _add_surroundings(spec, station)
    _add_pallet(spec, station)
    if station.load:
        _add_load(spec, station)
    _add_truck(spec, T_world_dock, tines)
    return spec.compile()


def pieces(model: ObjectModel) -> Iterator[tuple[str, OrientedBox | Float[np.ndarray, "n 3"]]]:
    """Yield the role and the shape of each piece of an object as it is drawn, worn as it is.

    A piece is a connected part of the surface: a box where it is one, else the corners of its convex hull (m).
    """
    for part in model.parts:
        mesh = part.placed()
        for vertices in _connected(mesh):
            box = _as_box(vertices)
            if box is not None:
                yield part.role, box
            elif (hull := _hull(vertices)) is not None:
                yield part.role, hull


def heading(T_world_dock: Transform) -> tuple[float, float]:
    """Return yaw and pitch (rad) of x of a frame in the world; pitch > 0 points up."""
    x = T_world_dock[:3, 0]
    return float(np.arctan2(x[1], x[0])), float(np.arcsin(np.clip(x[2], -1.0, 1.0)))


def _connected(mesh: TriangleMesh) -> list[Float[np.ndarray, "n 3"]]:
    vertices, where = np.unique(np.round(mesh.vertices, 6), axis=0, return_inverse=True)
    faces = where.reshape(-1)[mesh.faces]
    ends = np.concatenate([faces[:, :2], faces[:, 1:]])
    graph = coo_array((np.ones(len(ends)), ends.T), shape=(len(vertices),) * 2)
    count, label = connected_components(graph, directed=False)
    return [vertices[label == index] for index in range(count)]


def _as_box(vertices: Float[np.ndarray, "n 3"]) -> OrientedBox | None:
    """Return the box that has these eight corners, or None."""
    if len(vertices) != 8:
        return None
    away = vertices - vertices[0]
    edges = away[np.argsort(np.linalg.norm(away, axis=1), kind="stable")[1:]]
    for i in range(2):
        for j in range(i + 1, 4):
            for k in range(j + 1, 6):
                chosen = edges[[i, j, k]]
                lengths = np.linalg.norm(chosen, axis=1)
                axes = chosen / lengths[:, None]
                if np.abs(axes @ axes.T - np.eye(3)).max() < 1e-3 and np.isclose(
                    np.linalg.norm(chosen.sum(axis=0)), np.linalg.norm(away, axis=1).max(), rtol=1e-4
                ):
                    if np.linalg.det(axes) < 0.0:
                        axes[2] *= -1.0
                    u, _, vt = np.linalg.svd(axes.T)
                    return OrientedBox(make_transform(u @ vt, vertices.mean(axis=0)), lengths)
    return None


def _hull(vertices: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"] | None:
    """Return the corners of the convex hull; None of a flat sheet such as a label, which stops nothing."""
    try:
        hull = ConvexHull(vertices)
    except (QhullError, ValueError):
        return None
    return vertices[hull.vertices] if hull.volume > _PARALLEL else None


def _add_surroundings(spec: mujoco.MjSpec, station: Station) -> None:
    plane = mujoco.mjtGeom.mjGEOM_PLANE
    floor = (TRUCK.friction_floor, *FRICTION[1:])
    spec.worldbody.add_geom(name="floor", type=plane, size=[0.0, 0.0, 1.0], friction=floor, priority=1)
    for number, box in enumerate(station.around):
        high = box.T_parent_box[2, 3] + np.abs(box.T_parent_box[2, :3]) @ box.size / 2.0
        if high > 1e-4:  # the rest is the floor itself
            steel = (TRUCK.friction_steel, *FRICTION[1:])
            _add_box(spec.worldbody, box, name=f"around:{number}", friction=steel, priority=1)


def _add_pallet(spec: mujoco.MjSpec, station: Station) -> None:
    model = station.scene.model_of(station.pallet)
    body = _body(spec.worldbody, PALLET, station.pallet.T_world_object)
    body.add_freejoint()
    friction = (TRUCK.friction_load, *FRICTION[1:])
    shapes = list(pieces(model))
    volumes = [_volume(shape) for _, shape in shapes]
    for number, ((role, shape), volume) in enumerate(zip(shapes, volumes, strict=True)):
        settings = {"mass": model.mass * volume / sum(volumes), "friction": friction}
        name = f"{PALLET}:{role or 'piece'}:{number}"
        if isinstance(shape, OrientedBox):
            _add_box(body, shape, name=name, **settings)
        else:
            spec.add_mesh(name=name, uservert=shape.reshape(-1))
            body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, **settings)


def _volume(shape: OrientedBox | Float[np.ndarray, "n 3"]) -> float:
    return float(np.prod(shape.size) if isinstance(shape, OrientedBox) else ConvexHull(shape).volume)


def _add_load(spec: mujoco.MjSpec, station: Station) -> None:
    """Add what the pallet bears as one body: on its own it stays together, by film or because nothing shakes it."""
    T_world_load = station.load[0].T_world_object
    body = _body(spec.worldbody, LOAD, T_world_load)
    body.add_freejoint()
    friction = (TRUCK.friction_load, *FRICTION[1:])
    for item in station.load:
        model = station.scene.model_of(item)
        volume = sum(float(np.prod(box.size)) for box in model.collision)
        for number, box in enumerate(model.collision):
            placed = box.placed(invert(T_world_load) @ item.T_world_object)
            mass = max(model.mass, 1e-3) * float(np.prod(box.size)) / volume
            _add_box(body, placed, name=f"{LOAD}:{item.instance_id}:{number}", mass=mass, friction=friction)


def _add_truck(spec: mujoco.MjSpec, T_world_dock: Transform, tines: Float[np.ndarray, " t"]) -> None:
    """Add truck > lift > sideshifter > forks; drive and lift are where the heels are, counted from the dock frame."""
    _, pitch = heading(T_world_dock)
    base = _body(spec.worldbody, "truck", _level(T_world_dock))
    base.gravcomp = 1.0
    _weigh(base, TRUCK.truck_mass)
    _slide(base, "drive", (1.0, 0.0, 0.0))
    mast = _body(base, "mast", np.eye(4))
    _weigh(mast, 1.0)
    _slide(mast, "lift", (0.0, 0.0, 1.0))
    shifter = _body(mast, "shifter", make_transform(rotation_y(-pitch)))
    _weigh(shifter, 1.0)
    limits = {"limited": True, "solref_limit": (CONTACT_TIME, 1.0)}
    play = [-TRUCK.side_play, TRUCK.side_play]
    _slide(shifter, "side_play", (0.0, 1.0, 0.0), range=play, frictionloss=_HELD, damping=_HELD, **limits)
    forks = _body(shifter, FORKS, np.eye(4))
    mujoco_hinge = mujoco.mjtJoint.mjJNT_HINGE
    swing = {"range": np.rad2deg([0.0, TRUCK.tilt_play]), "pos": [0.0, 0.0, _PIVOT], "damping": 50.0}
    forks.add_joint(name="tilt_play", type=mujoco_hinge, axis=[0.0, -1.0, 0.0], **swing, **limits)
    _add_forks(spec, forks, tines)
    for name in ("drive", "lift"):
        servo = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        servo.set_to_position(kp=_SERVO, dampratio=1.0)


def _add_forks(spec: mujoco.MjSpec, forks: mujoco.MjsBody, tines: Float[np.ndarray, " t"]) -> None:
    friction = (TRUCK.friction_steel, *FRICTION[1:])
    half, straight = TINE_THICKNESS / 2.0, 0.75 * TINE_LENGTH
    settings = {"friction": friction, "priority": 2, "mass": TRUCK.carriage_mass / 3.0 / (3 * len(tines))}
    outline = [
        (straight, -half),
        (straight, half),
        (TINE_LENGTH, half),
        (TINE_LENGTH, half - TRUCK.tip_thickness),
    ]
    for number, y in enumerate(tines):
        blade = solid_box((straight, TINE_WIDTH, 2 * half), (straight / 2.0, y, 0.0))
        _add_box(forks, blade, name=f"{FORKS}:blade:{number}", **settings)
        beside = [y - TINE_WIDTH / 2.0, y + TINE_WIDTH / 2.0]
        corners = np.array([[x, side, z] for side in beside for x, z in outline])
        tip = f"{FORKS}:tip:{number}"
        spec.add_mesh(name=tip, uservert=corners.reshape(-1))
        forks.add_geom(name=tip, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=tip, **settings)
        shank = solid_box((2 * half, TINE_WIDTH, TRUCK.shank_height), (-half, y, TRUCK.shank_height / 2.0 - half))
        _add_box(forks, shank, name=f"{FORKS}:shank:{number}", **settings)
    low = 0.08
    size = (0.04, TRUCK.backrest_width, TRUCK.backrest_height - low)
    backrest = solid_box(size, (-2 * half - 0.02, 0.0, (TRUCK.backrest_height + low) / 2.0))
    settings["mass"] = TRUCK.carriage_mass * 2.0 / 3.0
    _add_box(forks, backrest, name=f"{FORKS}:backrest", **settings)


def _body(parent: mujoco.MjsBody, name: str, T: Transform) -> mujoco.MjsBody:
    return parent.add_body(name=name, pos=T[:3, 3], quat=quat_wxyz_from_matrix(T[:3, :3]))


def _weigh(body: mujoco.MjsBody, mass: float) -> None:
    body.mass, body.inertia, body.explicitinertial = mass, [0.2 * mass] * 3, True


def _slide(body: mujoco.MjsBody, name: str, axis: tuple[float, float, float], **settings: object) -> None:
    body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis, **settings)


def _add_box(body: mujoco.MjsBody, box: OrientedBox, **settings: object) -> None:
    quat = quat_wxyz_from_matrix(box.T_parent_box[:3, :3])
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX, size=box.size / 2.0, pos=box.T_parent_box[:3, 3], quat=quat, **settings
    )


def nearest_along(T_world_dock: Transform, corners: Float[np.ndarray, "n 3"]) -> float:
    """Return the least place (m) of points in the world along the level heading of a dock frame."""
    return float(transform_points(invert(_level(T_world_dock)), corners)[:, 0].min())


def _level(T_world_dock: Transform) -> Transform:
    """Return the frame at a dock frame that has its yaw alone."""
    return make_transform(rotation_z(heading(T_world_dock)[0]), T_world_dock[:3, 3])
