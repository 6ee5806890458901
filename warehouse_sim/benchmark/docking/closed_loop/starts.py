"""Where approaches begin: a truck before a side that it can take a pallet by, off its axis and turned."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice

import numpy as np

from warehouse_sim.annotate.dockable import accessibility
from warehouse_sim.annotate.trucks import TRUCKS
from warehouse_sim.benchmark.docking.questions import why_not
from warehouse_sim.benchmark.docking.station import Station, station_of
from warehouse_sim.benchmark.docking.world import heading
from warehouse_sim.errors import PlacementError
from warehouse_sim.estimators.tracking.tracker import View, in_sight
from warehouse_sim.evaluation.docking.fork import DockingFace
from warehouse_sim.generation.scene import SampledScene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene import scene_rng
from warehouse_sim.scene.solids import Solids
from warehouse_sim.scene.viewpoints.drives import FloorPose, Mount
from warehouse_sim.scene.viewpoints.free_space import UNDERFOOT, FreeSpace, vehicle_boxes
from warehouse_sim.scene.viewpoints.mountings import FORKLIFT, MOUNTINGS
from warehouse_sim.schema import FREE, UNDER_A_STACK, ObjectInstance, SceneSpec

KIND = "forklift_forks"
"""The camera is between the tips and goes up with the forks: it sees the face until the tips are before it."""
_DISTANCE = (4.0, 7.0)
"""From the truck's origin to the face (m)."""
_ASIDE, _OFFSET = 0.15, np.deg2rad(10.0)
"""How far the truck is beside the face's axis at most, as a fraction of the way to where its tips are before the face:
a truck with this radius cannot come onto the axis from farther. And the greatest angle between its heading and the line
to the face (rad)."""
_TRIES = 60
_BEYOND = 4.0
"""How far beyond the ends of the aisle a truck may stand (m), as on drives."""
_LEAST_SIGHT = 0.6
"""Fraction of the pallet's sample points that must be in sight, by boxes, as recipes have it."""
_WELL_OFF = 0.15
"""Error of the place to which a truck with a front end is sent (m, standard deviation along x and y)."""
_TOUCH = 0.001


@dataclass(frozen=True, eq=False)
class Start:
    """A truck before a pallet."""

    number: int
    """Of the start within its scene."""
    station: Station
    face: DockingFace
    pose: FloorPose
    mount: Mount
    commanded: np.ndarray
    """Where the truck is sent (m, world)."""

    @property
    def pallet(self) -> ObjectInstance:
        """What it goes for."""
        return self.station.pallet


def starts_in(sampled: SampledScene, camera: PinholeCamera, most: int, is_free: Callable[[Start], bool]) -> list[Start]:
    """Return up to ``most`` starts of a scene, each before another pallet; the same for the same scene.

    Args:
        sampled: The scene.
        camera: The truck's.
        most: How many.
        is_free: Whether nothing stands in the way of a start.
    """
    rng = scene_rng(sampled.scene.seed, sampled.scene.scene_index, "closed loop", sampled.scene.attempt)
    return list(islice(sampled_starts(sampled, camera, is_free, rng), most))


def sampled_starts(
    sampled: SampledScene, camera: PinholeCamera, is_free: Callable[[Start], bool], rng: np.random.Generator
) -> Iterator[Start]:
    """Yield starts of a scene, as ``starts_in``, by the stream ``rng``."""
    try:
        space = FreeSpace.of_scene(sampled.scene)
    except PlacementError:
        return
    found: list[Start] = []
    for station, face in _sides(sampled, rng):
        if any(item.pallet is station.pallet for item in found):
            continue
        start = _draw(len(found), station, face, space, camera, rng)
        if start is not None and is_free(start):
            found.append(start)
            yield start


def collisions_of(scene: SceneSpec, start: Start, with_pallet: bool = False) -> Callable[[FloorPose], bool]:
    """Return what says whether the truck at a pose touches anything but its pallet.

    Args:
        scene: With all that stands there.
        start: How high the forks are, and which pallet they go for.
        with_pallet: Whether its pallet counts, too.
    """
    others = Solids.of(scene.instances, scene.models)
    if not with_pallet:
        others = others.subset(~others.of_objects([start.pallet.instance_id]))
    obstacles = others.boxes.subset(others.extents[1][:, 2] > UNDERFOOT)

    def touches(pose: FloorPose) -> bool:
        bodies = BoxStack.of(vehicle_boxes(start.mount.view(pose), start.mount.lift))
        pairs = bodies.pairs(obstacles)
        return bool(np.min(bodies.separation(obstacles, pairs).distance, initial=np.inf) < -_TOUCH)

    return touches


def _sides(sampled: SampledScene, rng: np.random.Generator) -> Iterator[tuple[Station, DockingFace]]:
    """Yield the faces with evaluated docking, in random order."""
    scene = sampled.scene
    reach = accessibility(scene, TRUCKS[sampled.settings.layout.truck])
    sides = [(number, name) for number, item in reach.items() for name in item.faces]
    solids = Solids.of(scene.instances, scene.models)
    for index in rng.permutation(len(sides)):
        number, name = sides[index]
        verdict = reach[number].faces[name]
        if verdict not in (FREE, UNDER_A_STACK):
            continue
        station = station_of(scene, number, solids)
        face = station.face(name)
        if not why_not(station, face, verdict):
            yield station, face


def _draw(
    number: int,
    station: Station,
    face: DockingFace,
    space: FreeSpace,
    camera: PinholeCamera,
    rng: np.random.Generator,
) -> Start | None:
    pallet = station.pallet
    T_world_dock = pallet.T_world_object @ face.T_object_dock
    yaw, _ = heading(T_world_dock)
    mounting = MOUNTINGS[KIND]
    lift = max(0.0, float(pallet.T_world_object[2, 3] - station.scene.model_of(pallet).size[2] / 2.0))
    height, pitch = mounting.height.sample(rng) + lift, float(np.deg2rad(mounting.pitch_deg.sample(rng)))
    mount = Mount(KIND, mounting, height, pitch, lift)
    commanded = pallet.T_world_object[:3, 3] + np.array([*rng.normal(0.0, _WELL_OFF, 2), 0.0])
    for _ in range(_TRIES):
        back = float(rng.uniform(*_DISTANCE))
        aside = float(rng.uniform(-_ASIDE, _ASIDE)) * (back - FORKLIFT.tip)
        ahead, left = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
        x, y = T_world_dock[:2, 3] - back * ahead + aside * left
        turned = -float(np.arctan2(aside, back)) + float(rng.uniform(-_OFFSET, _OFFSET))
        pose = FloorPose(float(x), float(y), yaw + turned)
        view = mount.view(pose)
        here = View(0, 0, camera, view.T_world_camera, 0.0)
        if not space.area.x_min - _BEYOND <= x <= space.area.x_max + _BEYOND:
            continue
        if not space.admits_bodies(vehicle_boxes(view, lift)) or not in_sight(here, pallet.T_world_object[:3, 3]):
            continue
        if space.sight_fraction(view.T_world_camera[:3, 3], pallet) >= _LEAST_SIGHT:
            return Start(number, station, face, pose, mount, commanded)
    return None
