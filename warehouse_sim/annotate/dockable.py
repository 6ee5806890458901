"""Can a truck take this pallet by this face, as it stands? From collision boxes alone, before any simulation.

The truck stands straight before the face, its tines level with the pockets and their tips just outside, and drives in
until its heel is a hand's width from the face, or its tips reach the far side of a pallet that is less deep than they
are long. Tines, mast and body sweep boxes; none may touch anything else.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from warehouse_sim.annotate.trucks import DRIVE, HEEL_GAP, TruckOutline, early_stop
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z, transform_points
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import FREE, UNDER_A_STACK, Accessibility, ObjectInstance, Pocket, SceneSpec

_CONTACT = 0.02
"""Boxes this near (m) touch; settled loads have smaller gaps, racks leave larger ones."""
_UPRIGHT = 0.7
"""Least vertical fraction of the axis between two boxes for the lower one to carry the upper one."""


def stacked_pallets(scene: SceneSpec, solids: Solids) -> tuple[set[int], set[int]]:
    """Return the instance ids of the pallets on which another pallet stands, and of those that stand on another.

    Args:
        scene: The settled scene.
        solids: Its collision boxes.
    """
    goods = {item.instance_id for item in scene.instances if item.group > 0}
    pallets = {item.instance_id for item in scene.instances if scene.model_of(item).class_name == "pallet"} & goods
    carried = _carried_by(solids.subset(solids.of_objects(goods)))
    under: set[int] = set()
    upon: set[int] = set()
    for bottom in pallets:
        reached: set[int] = set()
        front = {bottom}
        while front:
            front = {upper for lower in front for upper in carried[lower]} - reached
            reached |= front
        above = (reached & pallets) - {bottom}
        if above:
            under.add(bottom)
            upon |= above
    return under, upon


def _carried_by(solids: Solids) -> dict[int, set[int]]:
    """Return what stands directly on each object, by instance id."""
    stack, owner = solids.boxes, solids.owner
    pairs = stack.pairs(stack, _CONTACT)
    pairs = pairs[owner[pairs[:, 0]] != owner[pairs[:, 1]]]
    result = stack.separation(stack, pairs)
    rests = (result.axis[:, 2] > _UPRIGHT) & (result.distance < _CONTACT)
    carried: dict[int, set[int]] = defaultdict(set)
    for lower, upper in np.unique(owner[pairs[rests]], axis=0).tolist():
        carried[lower].add(upper)
    return carried


_TOUCH = 0.001
"""Boxes that overlap by less (m) do not touch: settled things rest in each other by tenths of a millimetre."""
_EDGE = 0.1
"""How far a truck may be over the edge of the aisle (m); what stands there is looked at anyway."""
_LONGEST_LANE = 20.0
"""Farthest that a truck drives straight in from the aisle (m)."""
_LEAN = np.deg2rad(5.0)
"""Largest tilt of a pallet that a mast follows; practical prior, masts tilt forward by 3 to 6 degrees."""


@dataclass(frozen=True, eq=False)
class Entry:
    """A face of a target, and where a truck would stand before it."""

    target: ObjectInstance
    face: str
    T_world_entry: Transform
    """On the floor under the middle of the openings, x horizontally into the pallet, z up."""
    height: float
    """Of the middle of the tines above the floor (m)."""
    offsets: np.ndarray
    """Of the pockets, to the left of the middle (m)."""
    lean: float
    """Angle of the pallet's upright axis to the vertical (rad)."""
    depth: float
    """From the face to the far side of the pallet (m)."""


def accessibility(scene: SceneSpec, truck: TruckOutline) -> dict[int, Accessibility]:
    """Judge every face with pockets of every target of a settled scene.

    Args:
        scene: The scene; without ``aisle`` any floor will do.
        truck: What takes pallets in it.

    Returns:
        By instance id, of targets with pockets.
    """
    solids = Solids.of(scene.instances, scene.models)
    obstacles = solids.joined(_whole_pallets(scene))
    under, upon = stacked_pallets(scene, solids)
    entries = entries_of(scene)
    afar = [_from_afar(entry, scene.aisle, truck) for entry in entries]
    verdicts = [_before_touching(entry, way, truck) for entry, way in zip(entries, afar, strict=True)]
    # Right before the face first: most that is blocked is blocked there, and lanes are long.
    for ways in ([0.0] * len(afar), afar):
        for words, sweep in _stages(truck).items():
            left = [i for i, verdict in enumerate(verdicts) if verdict == FREE and (ways is not afar or afar[i] > 0.0)]
            boxes = [[box.placed(entries[i].T_world_entry) for box in sweep(entries[i], ways[i])] for i in left]
            for i, other in zip(left, _touched([entries[i] for i in left], boxes, obstacles), strict=True):
                if other:
                    verdicts[i] = f"{words} {_name(scene, entries[i].target, other)}"
    found: dict[int, dict[str, str]] = {}
    for entry, verdict in zip(entries, verdicts, strict=True):
        number = entry.target.instance_id
        under_stack = verdict == FREE and number in under
        found.setdefault(number, {})[entry.face] = UNDER_A_STACK if under_stack else verdict
    return {number: Accessibility(faces, number in under | upon) for number, faces in found.items()}


def dockable_headings(scene: SceneSpec, truck: TruckOutline) -> dict[int, list[float]]:
    """Return the headings (rad, world) straight into the free faces of pallets that stand alone, by instance id."""
    found: dict[int, list[float]] = {}
    access = accessibility(scene, truck)
    for entry in entries_of(scene):
        number = entry.target.instance_id
        if access[number].faces[entry.face] == FREE and not access[number].stacked:
            ahead = entry.T_world_entry[:2, 0]
            found.setdefault(number, []).append(float(np.arctan2(ahead[1], ahead[0])))
    return found


def _stages(truck: TruckOutline) -> dict[str, Callable[[Entry, float], Iterable[OrientedBox]]]:
    """Return what sweeps, by the words for what it touches."""
    return {
        "blocked by": lambda entry, way: truck.tines(entry.height, entry.offsets, way, early_stop(entry.depth)),
        "mast blocked by": lambda entry, way: truck.swept(truck.mast, entry.height, way, early_stop(entry.depth)),
        "no room for the truck:": lambda entry, way: truck.swept(
            truck.body, entry.height, way, early_stop(entry.depth)
        ),
    }


def entries_of(scene: SceneSpec) -> list[Entry]:
    """Return all faces with pockets of all targets, by instance id and face."""
    entries = []
    for target in scene.target_instances():
        pockets = scene.model_of(target).pockets
        for face in sorted({pocket.face for pocket in pockets}):
            depth = float(scene.model_of(target).size["xy".index(face[1])])
            entries.append(_entry(target, face, [pocket for pocket in pockets if pocket.face == face], depth))
    return entries


def _whole_pallets(scene: SceneSpec) -> Solids:
    """Return everything with pockets as one box each: tips in the pockets of another pallet would lift it, too."""
    items = [item for item in scene.instances if scene.model_of(item).pockets]
    frames = np.array([item.T_world_object for item in items]).reshape(-1, 4, 4)
    half = np.array([scene.model_of(item).size for item in items], dtype=float).reshape(-1, 3) / 2.0
    owner = np.array([item.instance_id for item in items], dtype=np.int64)
    return Solids(owner, BoxStack(frames[:, :3, 3], frames[:, :3, :3], half))


def _entry(target: ObjectInstance, face: str, pockets: Sequence[Pocket], depth: float) -> Entry:
    T_world_pocket = np.array([target.T_world_object @ pocket.T_object_pocket for pocket in pockets])
    middle, ahead = T_world_pocket[:, :3, 3].mean(axis=0), T_world_pocket[0, :3, 0]
    turn = rotation_z(float(np.arctan2(ahead[1], ahead[0])))
    T_world_entry = make_transform(turn, np.array([middle[0], middle[1], 0.0]))
    lean = float(np.arccos(np.clip(target.T_world_object[2, 2], -1.0, 1.0)))
    offsets = (T_world_pocket[:, :3, 3] - middle) @ turn[:, 1]
    return Entry(target, face, T_world_entry, float(middle[2]), offsets, lean, depth)


def _from_afar(entry: Entry, aisle: tuple[float, float, float, float] | None, truck: TruckOutline) -> float:
    """Return how much farther back than right before the face the truck is all over the aisle (m), inf for never.

    Loads in lanes are taken so: the truck drives in from the aisle, through what is free of the lane.
    """
    if aisle is None:
        return 0.0
    ends = np.array([[truck.rear, 0.0, 0.0], [-HEEL_GAP - DRIVE, 0.0, 0.0]])
    start, back = transform_points(entry.T_world_entry, ends)[:, :2], -entry.T_world_entry[:2, 0]
    low, high = np.array(aisle[::2]) - _EDGE, np.array(aisle[1::2]) + _EDGE
    # Of a line across neither border the slope is taken as tiny: it is always between them or never.
    slope = np.where(np.abs(back) < 1e-9, 1e-9, back)
    crossings = np.sort(np.stack([(low - start) / slope, (high - start) / slope]), axis=0)
    way = max(0.0, float(crossings[0].max()))
    possible = way <= crossings[1].min() and way <= _LONGEST_LANE and (way == 0.0 or truck.enters_lanes)
    return way if possible else float("inf")


def _before_touching(entry: Entry, from_afar: float, truck: TruckOutline) -> str:
    """Return what rules a face out before any box is looked at, else ``FREE``."""
    if entry.lean > _LEAN:
        return "leaning"
    if entry.height > truck.lift:
        return "higher than the forks go"
    return FREE if np.isfinite(from_afar) else "outside the aisle"


def _touched(entries: Sequence[Entry], boxes: Sequence[Sequence[OrientedBox]], solids: Solids) -> list[int]:
    """Return for each entry the instance id of what its boxes reach deepest into, 0 for nothing."""
    rows = np.array([row for row, mine in enumerate(boxes) for _ in mine], dtype=np.int64)
    swept = BoxStack.of([box for mine in boxes for box in mine])
    pairs = swept.pairs(solids.boxes)
    own = np.array([entry.target.instance_id for entry in entries], dtype=np.int64)
    pairs = pairs[solids.owner[pairs[:, 1]] != own[rows[pairs[:, 0]]]] if len(pairs) else pairs
    depth = -swept.separation(solids.boxes, pairs).distance
    found = [0] * len(entries)
    for pair in np.argsort(depth, kind="stable")[np.count_nonzero(depth <= _TOUCH) :]:
        found[rows[pairs[pair, 0]]] = int(solids.owner[pairs[pair, 1]])
    return found


def _name(scene: SceneSpec, target: ObjectInstance, instance_id: int) -> str:
    item = next(item for item in scene.instances if item.instance_id == instance_id)
    own = item.group > 0 and item.group == target.group
    return "its own load" if own else scene.model_of(item).class_name.replace("_", " ")
