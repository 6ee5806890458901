"""Warehouse workers in high-visibility clothing, helmet and safety shoes: three statures, standing and walking.

Statures are the 5th percentile of women, the 50th and the 95th of men of DIN 33402-2:2005 (18-65 years): 1535, 1750 and
1855 mm. Each faces +x.
"""

from warehouse_sim.catalog.traffic.figure import Figure, Pose, Worker
from warehouse_sim.catalog.traffic.shapes import assembled
from warehouse_sim.errors import UnknownNameError
from warehouse_sim.schema import ObjectModel

WORKERS = {
    "small": Worker(170, 1.535, 0.98, 56.0, "hivis_orange", "cloth_grey", "cloth_navy", "skin_light", "helmet_white"),
    "medium": Worker(172, 1.75, 1.02, 82.0, "hivis_yellow", "cloth_navy", "cloth_navy", "skin_medium", "helmet_yellow"),
    "tall": Worker(174, 1.855, 1.08, 103.0, "hivis_yellow", "hivis_yellow", "cloth_grey", "skin_dark", "helmet_white"),
}
"""Stature in the catalog name -> person."""
POSES = {
    "standing": Pose((2.0, -1.0), (-2.0, -3.0), (-4.0, 6.0), (12.0, 62.0), (0.0, 0.0)),
    "walking": Pose((24.0, -16.0), (10.0, -38.0), (-24.0, 22.0), (-4.0, 44.0), (8.0, -26.0)),
}
"""Pose in the catalog name -> angles."""
PEOPLE = {f"person_{stature}_{pose}": (stature, pose) for stature in WORKERS for pose in POSES}
"""Catalog name -> stature and pose."""


def person(name: str) -> ObjectModel:
    """Build a worker ("person_medium_walking").

    Raises:
        UnknownNameError: Nobody has this name; see ``PEOPLE``.
    """
    if name not in PEOPLE:
        raise UnknownNameError("person", name, list(PEOPLE))
    stature, stance = PEOPLE[name]
    figure = Figure(WORKERS[stature], POSES[stance])
    obj_id = WORKERS[stature].obj_id + list(POSES).index(stance)
    return assembled(name, "person", obj_id, figure.parts, figure.boxes, WORKERS[stature].mass)
