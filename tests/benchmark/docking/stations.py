"""A pallet on a bare floor, with a load or without, for a truck to take."""

from dataclasses import replace

import numpy as np

from warehouse_sim.benchmark.docking.station import Station, station_of
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.parts import solid_box
from warehouse_sim.geometry.pose import Transform, invert, make_transform, rotation_y, rotation_z
from warehouse_sim.schema import ObjectInstance, ObjectModel, SceneSpec


def at(x: float, y: float, z: float, yaw: float = 0.0) -> Transform:
    """Return a pose by place (m) and yaw (rad)."""
    return make_transform(rotation_z(yaw), np.array([x, y, z]))


def station(load_kg: float = 0.0, pallet: str = "epal1", pose: Transform | None = None, load_x: float = 0.0) -> Station:
    """Return a pallet on the floor, under a box of ``load_kg`` whose middle is at ``load_x`` (m) along the pallet."""
    model = catalog_object(pallet)
    half = float(model.size[2]) / 2.0
    T = at(0.0, 0.0, half) if pose is None else pose
    models, instances = {pallet: model}, [ObjectInstance(1, pallet, T, dynamic=True, group=1)]
    if load_kg:
        size = (1.2 - 2 * abs(load_x), 0.8, 0.6)
        box = ObjectModel("box", "carton", 99, np.array(size), (), (solid_box(size),), mass=load_kg)
        models["box"] = box
        instances.append(ObjectInstance(2, "box", T @ at(load_x, 0.0, half + 0.3), dynamic=True, group=1))
    return station_of(SceneSpec(0, 0, models, {}, tuple(instances), (), (), settled=True), 1)


def wrong(depth: float = 0.0, lateral: float = 0.0, vertical: float = 0.0, yaw: float = 0.0, pitch: float = 0.0):
    """Return an estimate, in the dock frame, that is wrong by that much at the entry (m, rad)."""
    return make_transform(rotation_z(yaw) @ rotation_y(-pitch), np.array([depth, lateral, vertical]))


def estimate(place: Station, face: str, **errors: float) -> Transform:
    """Return that estimate in the object frame."""
    T = place.face(face).T_object_dock
    return T @ wrong(**errors) @ invert(T)


def beside(place: Station, **changes: object) -> Station:
    """Return a station with some of its fields changed."""
    return replace(place, **changes)
