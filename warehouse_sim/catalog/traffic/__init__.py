"""Who and what moves through the aisles or stands in the way: people, trucks, cones, bollards, loose film.

All face +x; origin at the centre of the bounding box, z up.
"""

from warehouse_sim.catalog.traffic.obstacles import CONES, WRAPS
from warehouse_sim.catalog.traffic.people import PEOPLE

_ROOM = "warehouse_sim.catalog.traffic"
TRAFFIC = {
    **dict.fromkeys(PEOPLE, f"{_ROOM}.people:person"),
    **{name: f"{_ROOM}.trucks:{name}" for name in ("pallet_jack", "forklift", "reach_truck")},
    **dict.fromkeys(CONES, f"{_ROOM}.obstacles:cone"),
    **dict.fromkeys(WRAPS, f"{_ROOM}.obstacles:hanging_wrap"),
    "bollard": f"{_ROOM}.obstacles:bollard",
    "floor_sign": f"{_ROOM}.obstacles:floor_sign",
}
"""Catalog name -> where its builder is."""

STANDING = {
    "bollard": ("bollard",),
    "cone": tuple(sorted(CONES)),
    "forklift": ("forklift", "reach_truck"),
    "pallet_jack": ("pallet_jack",),
    "person": tuple(sorted(PEOPLE)),
}
"""Class -> the catalog names of it that are drawn, each as often, where a recipe asks for the class."""

__all__ = ["CONES", "PEOPLE", "STANDING", "TRAFFIC", "WRAPS"]
