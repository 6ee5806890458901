"""A truck before a lone pallet, and estimators that are right, wrong, silent or unsure."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from warehouse_sim.benchmark.docking.closed_loop.belief import Believed
from warehouse_sim.benchmark.docking.closed_loop.drive import Approach, Approacher, Glance
from warehouse_sim.benchmark.docking.closed_loop.perceive import Oracle
from warehouse_sim.benchmark.docking.closed_loop.settings import BASE, DRIFTS, Condition
from warehouse_sim.benchmark.docking.closed_loop.starts import KIND, Start
from warehouse_sim.benchmark.docking.station import Station
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.scene.viewpoints.drives import FloorPose, Mount
from warehouse_sim.scene.viewpoints.mountings import MOUNTINGS
from warehouse_sim.schema import PoseEstimate

CAMERA = PinholeCamera.from_focal(1224, 370, 707.0)
MOUNT = Mount(KIND, MOUNTINGS[KIND], 0.4, 0.0, 0.0)
NO_DRIFT = replace(BASE, drift="none")


def start_at(place: Station, face: str, back: float, aside: float, turned: float) -> Start:
    """Return a truck ``back`` before a face, ``aside`` to the left of its axis (m), ``turned`` to the left (rad)."""
    T = place.pallet.T_world_object @ place.face(face).T_object_dock
    yaw = float(np.arctan2(T[1, 0], T[0, 0]))
    x, y = T[:2, 3] - back * T[:2, 0] + aside * T[:2, 1]
    pose = FloorPose(float(x), float(y), yaw + turned)
    return Start(0, place, place.face(face), pose, MOUNT, place.pallet.T_world_object[:3, 3])


def gt(start: Start, T_object_wrong: Transform | None = None) -> Oracle:
    """Return who knows the pallet, or is wrong by always the same."""
    return Oracle(start.pallet, start.station.scene.model_of(start.pallet), CAMERA, T_object_wrong)


@dataclass
class Until:
    """Estimates as another until some image, from then on as ``then`` does."""

    other: Callable[[Glance], PoseEstimate | None]
    image: int = 0
    score: float | None = None
    """Of what is estimated from then on; None gives nothing."""
    min_score: float = 0.2

    def __call__(self, glance: Glance) -> PoseEstimate | None:
        """Return the estimate."""
        found = self.other(glance)
        if glance.index < self.image or found is None:
            return found
        return None if self.score is None else replace(found, score=self.score)


def approach(
    start: Start,
    perceive: Callable[[Glance], PoseEstimate | None],
    condition: Condition = NO_DRIFT,
    touches: Callable[[FloorPose], bool] = lambda pose: False,
    seed: int = 0,
    sides: tuple[str, ...] = ("-x", "+x", "-y", "+y"),
) -> Approach:
    """Drive to a pallet that is taken by some of its sides."""
    model = start.station.scene.model_of(start.pallet)
    believed = Believed(
        model.symmetry,
        [face for face in start.station.faces if face.name in sides],
        DRIFTS[condition.drift],
        condition.is_open,
    )
    truck = Approacher(start.mount, CAMERA, believed, perceive, condition, touches)
    return truck.run(start.pose, np.random.default_rng(seed))
