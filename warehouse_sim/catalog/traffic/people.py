"""Warehouse workers in high-visibility clothing, helmet and safety shoes: three statures, on foot and on trucks.

"person_..." are the coarse ones that older datasets hold, "worker_..." the finely divided ones, in more poses.

Statures are the 5th percentile of women, the 50th and the 95th of men of DIN 33402-2:2005 (18-65 years): 1535, 1750 and
1855 mm. Each faces +x.
"""

from functools import cache

import numpy as np

from warehouse_sim.catalog.traffic.figure import FINE, Figure, Pose, Worker
from warehouse_sim.catalog.traffic.shapes import assembled, centre_of
from warehouse_sim.geometry.pose import Transform, make_transform
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
    """Build a worker ("person_medium_walking")."""
    stature, stance = PEOPLE[name]
    figure = Figure(WORKERS[stature], POSES[stance])
    obj_id = WORKERS[stature].obj_id + list(POSES).index(stance)
    return assembled(name, "person", obj_id, figure.parts, figure.boxes, WORKERS[stature].mass)


WORKER_POSES = {
    "waiting": Pose((3.0, -2.0), (-1.0, -4.0), (-3.0, 14.0), (10.0, 96.0), (0.0, 0.0)),
    "striding": Pose((-18.0, 27.0), (-42.0, 12.0), (24.0, -26.0), (48.0, -2.0), (-28.0, 10.0), 4.0),
    "pushing": Pose((30.0, -14.0), (-4.0, -34.0), (42.0, 38.0), (74.0, 72.0), (0.0, -22.0), 12.0),
    "kneeling": Pose((84.0, 2.0), (2.0, -88.0), (34.0, 30.0), (62.0, 66.0), (0.0, -62.0), 16.0),
    "lifting": Pose((58.0, 44.0), (-24.0, -36.0), (28.0, 26.0), (46.0, 44.0), (0.0, -10.0), 38.0),
    "seated": Pose((84.0, 80.0), (20.0, 24.0), (34.0, 30.0), (82.0, 88.0), (4.0, 6.0)),
    "driving": Pose((4.0, -3.0), (0.0, -6.0), (22.0, 26.0), (78.0, 82.0), (0.0, 0.0), 2.0),
}
"""Pose in the catalog name of a finely divided worker -> angles; the last two are drivers', seated and standing."""
ON_TRUCKS = ("seated", "driving")
"""Poses of those who drive."""
_FIRST_ID = 550
WORKERS_BY_NAME = {f"worker_{stature}_{pose}": (stature, pose) for stature in WORKERS for pose in WORKER_POSES}
"""Catalog name -> stature and pose."""


@cache
def _figure(stature: str, pose: str) -> Figure:
    return Figure(WORKERS[stature], WORKER_POSES[pose], FINE)


def worker(name: str) -> ObjectModel:
    """Build a finely divided worker ("worker_medium_kneeling")."""
    stature, pose = WORKERS_BY_NAME[name]
    figure = _figure(stature, pose)
    obj_id = _FIRST_ID + list(WORKERS_BY_NAME).index(name)
    return assembled(name, "person", obj_id, figure.parts, figure.boxes, WORKERS[stature].mass)


def hips_of(name: str) -> Transform:
    """Return ``T_object_hips`` of a worker: between the hip joints, x forwards, z up."""
    figure = _figure(*WORKERS_BY_NAME[name])
    return make_transform(translation=np.array([0.0, 0.0, figure.hip]) - centre_of(figure.parts))


def feet_of(name: str) -> Transform:
    """Return ``T_object_feet`` of a worker: on the floor under the hips."""
    figure = _figure(*WORKERS_BY_NAME[name])
    return make_transform(translation=-centre_of(figure.parts))
