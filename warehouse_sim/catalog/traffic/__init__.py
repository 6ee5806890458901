"""Who and what moves through the aisles or stands in the way: people, trucks, cones, bollards, loose film.

All face +x; origin at the centre of the bounding box, z up.
"""

from warehouse_sim.catalog.traffic.obstacles import CONES, FINE_CONES, WRAPS
from warehouse_sim.catalog.traffic.people import ON_TRUCKS, PEOPLE, WORKERS_BY_NAME
from warehouse_sim.catalog.traffic.working import WORKING

_HERE = "warehouse_sim.catalog.traffic"
TRAFFIC = {
    **dict.fromkeys(PEOPLE, f"{_HERE}.people:person"),
    **{name: f"{_HERE}.trucks:{name}" for name in ("pallet_jack", "forklift", "reach_truck")},
    **dict.fromkeys(CONES, f"{_HERE}.obstacles:cone"),
    **dict.fromkeys(WRAPS, f"{_HERE}.obstacles:hanging_wrap"),
    **dict.fromkeys(WORKERS_BY_NAME, f"{_HERE}.people:worker"),
    **dict.fromkeys(FINE_CONES, f"{_HERE}.obstacles:traffic_cone"),
    **dict.fromkeys(WORKING, f"{_HERE}.working:working_truck"),
    "bollard": f"{_HERE}.obstacles:bollard",
    "floor_sign": f"{_HERE}.obstacles:floor_sign",
}
"""Catalog name -> where its builder is."""
WORKING_CLASSES = ("amr", "cart", "forklift", "pallet_jack", "person", "tugger")
"""Classes of who and what is at work in the aisles; a recipe can have them labelled."""

STANDING = {
    "bollard": ("bollard",),
    "cone": tuple(sorted(CONES)),
    "forklift": ("forklift", "reach_truck"),
    "pallet_jack": ("pallet_jack",),
    "person": tuple(sorted(PEOPLE)),
}
"""Class -> the catalog names of it that are sampled, each as often, where a recipe requires the class."""
FINE_STANDING = {
    **STANDING,
    "cone": tuple(sorted(FINE_CONES)),
    "pallet_jack": ("hand_pallet_truck",),
    "person": tuple(sorted(name for name, (_, pose) in WORKERS_BY_NAME.items() if pose not in (*ON_TRUCKS, "pushing"))),
}
"""The same of the finely divided ones; who pushes belongs to a truck."""

__all__ = ["CONES", "FINE_STANDING", "PEOPLE", "STANDING", "TRAFFIC", "WORKING", "WORKING_CLASSES", "WRAPS"]
