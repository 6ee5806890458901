"""An empty pallet stood on its edge against whatever is behind it: a rack's upright, a load, a wall, a column."""

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog.materials import materials_of
from warehouse_sim.generation.occlusion.occluded_scene import OccludedScene, fraction_behind, ground_line
from warehouse_sim.generation.occlusion.occluder import Occluder
from warehouse_sim.generation.occlusion.sight import Sight
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_x, rotation_z
from warehouse_sim.physics.rest import RestLimits, bring_to_rest
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import ObjectInstance, ObjectModel, SceneSpec

HEIGHT = 1.1
"""Height (m) that a pallet reaches when it leans on its short edge."""
_LOW = 0.75
"""Height (m) that it reaches on its long edge."""
_LEAN_DEG = (9.0, 16.0)
"""Range of the angle between pallet and vertical (deg)."""
_PLACES = 14
"""Places along the support that are tried."""
_BEYOND = 0.15
"""How far over the aisle's edge it may lean (m): uprights and loads do not stand exactly there."""
_RUN_UP = 0.5
"""How far before the target's front the push begins (m)."""
_PUSHES = 40
_TOUCH = 0.001
"""Pushed against its support until the gap is this small (m)."""
_AROUND = 0.1
"""What comes so near (m) may hold it."""
_SLIP, _LIMITS = 0.02, RestLimits(speed=0.002, turn=0.01, time=2.0)
"""Most that it may slip (m) when it is let go, and when it counts as at rest."""
_FLOOR = OrientedBox(make_transform(translation=np.array([0.0, 0.0, -0.5])), np.array([100.0, 100.0, 1.0]))


def leaning_pallet(model: ObjectModel) -> Occluder:
    """Return a pallet as an occluder whose frame is the pallet's own."""
    loose = ObjectInstance(1, model.name, np.eye(4), dynamic=True, group=1)
    return Occluder("pallet", {model.name: model}, (loose,))


def find_leaning_pose(
    occluded: OccludedScene,
    sight: Sight,
    occluder: Occluder,
    least_height: float,
    wanted: float,
    tolerance: float,
    rng: np.random.Generator,
) -> Transform | None:
    """Return where a leaning pallet leaves the ``wanted`` fraction within ``tolerance``; None for nowhere.

    It is pushed on, straight into the rack or along the aisle, until its upper edge touches something; then it is let
    go in the simulation and must stay.
    """
    target = occluded.instance_of[sight.target]
    model = occluder.models[occluder.instances[0].model]
    way, length = ground_line(sight, target.T_world_object[:3, 3])
    ahead = np.eye(2)[np.argmax(np.abs(way))] * np.sign(way[np.argmax(np.abs(way))])
    across = np.array([-ahead[1], ahead[0]])
    width = float(rng.choice(model.size[:2]) if least_height < _LOW else model.size[1])
    reach = (width + float(np.linalg.norm(occluded.scene.model_of(target).size[:2]))) / 2
    tilt = np.deg2rad(rng.uniform(*_LEAN_DEG))
    # What it may lean against is in line with the target's front, as its own load and the uprights beside it are.
    front = target.T_world_object[:2, 3] - way * (0.5 * float(model.size[0]) + _RUN_UP) / (way @ ahead)
    for offset in rng.uniform(-reach, reach, _PLACES):
        start = _edge_up(model, width, tilt, ahead, front + offset * across)
        T_world_pallet = _pushed(occluded, model, start, ahead, length)
        if T_world_pallet is None or abs(fraction_behind(sight, occluder, T_world_pallet) - wanted) > tolerance:
            continue
        if occluded.is_beside_added(OrientedBox(T_world_pallet, model.size), _AROUND):
            continue  # paired variants without that would leave it in the air
        resting = _let_go(occluded.solids, model, T_world_pallet)
        if resting is not None and abs(fraction_behind(sight, occluder, resting) - wanted) <= tolerance:
            return resting
    return None


def _edge_up(
    model: ObjectModel, width: float, tilt: float, ahead: Float[np.ndarray, " 2"], at: Float[np.ndarray, " 2"]
) -> Transform:
    """Return a pallet on its edge of length ``width`` (m), its deck towards us, its top tilted ahead (rad)."""
    long_down = width == model.size[0]
    # x along the lower edge, y up the pallet, z its deck's normal, which points back.
    upright = rotation_x(np.pi / 2 - tilt) if long_down else rotation_x(np.pi / 2 - tilt) @ rotation_z(np.pi / 2)
    heading = rotation_z(float(np.arctan2(ahead[1], ahead[0])) - np.pi / 2)
    R = heading @ upright
    box = OrientedBox(make_transform(R), model.size)
    lift = -float(box.corners()[:, 2].min())
    return make_transform(R, np.array([*at, lift + _TOUCH / 2]))


def _pushed(
    occluded: OccludedScene, model: ObjectModel, T_world_pallet: Transform, ahead: Float[np.ndarray, " 2"], most: float
) -> Transform | None:
    """Return the pallet pushed ahead until it touches a solid with its upper half; None if it never does, or below.

    Each push goes as far as the gap is wide, so that it cannot pass through anything (conservative advancement).
    """
    T = T_world_pallet.copy()
    for _ in range(_PUSHES):
        box = OrientedBox(T, model.size)
        gap = occluded.solids.gap(box, most)
        if gap < 0.0 or not np.isfinite(gap) or not all(occluded.area.contains(at, -_BEYOND) for at in box.corners()):
            return None
        if gap <= _TOUCH:
            return T if _touches_high(occluded.solids, box) else None
        T[:2, 3] += gap * ahead
    return None


def _touches_high(solids: Solids, box: OrientedBox) -> bool:
    """Return whether what ``box`` touches reaches the upper third of it."""
    top = box.corners()[:, 2].max()
    return any(solid.corners()[:, 2].max() > 0.67 * top for solid in solids.listed(solids.near_box(box, _TOUCH)))


def _let_go(solids: Solids, model: ObjectModel, T_world_pallet: Transform) -> Transform | None:
    """Return where the pallet comes to rest among what is around it; None if it slips or falls."""
    item = ObjectInstance(1, model.name, T_world_pallet, dynamic=True)
    scene = SceneSpec(0, 0, {model.name: model}, materials_of([model]), (item,), (), ())
    around = solids.listed(solids.near_box(OrientedBox(T_world_pallet, model.size), _AROUND))
    rest = bring_to_rest(scene, [item], [_FLOOR, *around], _LIMITS)
    T = rest.poses[1]
    moved = np.linalg.norm(T[:3, 3] - T_world_pallet[:3, 3])
    return T if rest.within(_LIMITS) and moved < _SLIP else None
