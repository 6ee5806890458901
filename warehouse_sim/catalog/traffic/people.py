"""Warehouse workers in high-visibility clothing, helmet and safety shoes: three statures, on foot and on trucks.

"person_..." are the coarse ones that older datasets hold, "worker_..." the finely divided ones, in more poses. A body
is put together from tubes and rounded blocks: limbs, trunk, head and what they wear. Each faces +x.

Statures are the 5th percentile of women, the 50th and the 95th of men of DIN 33402-2:2005 (18-65 years): 1535, 1750 and
1855 mm. Measures are fractions of stature: segments after Drillis and Contini (1966), as in Winter, Biomechanics and
Motor Control of Human Movement, figure 4.1; breadths and depths fit DIN 33402-2 with work clothes. Vest with two bands
around and two over the shoulders, 50 mm wide (EN ISO 20471, class 2).
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog.parts import Triple, mesh_part, solid_part
from warehouse_sim.catalog.traffic.shapes import assembled, centre_of, limb_box, smoothed, tube
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_y
from warehouse_sim.geometry.solids import lathe, superellipsoid
from warehouse_sim.schema import ObjectModel, Part

Vector = Float[np.ndarray, " 3"]
Piece = tuple[list[Part], list[OrientedBox]]
"""What is sampled and what collides."""

SOLE, HELMET = 0.03, 0.035
"""Height that safety shoes and a helmet add (m)."""
BAND = 0.05
"""Width of a reflective band (m), the least that EN ISO 20471 allows."""

_HIP, _NECK = 0.53, 0.80
_TRUNK = np.array(  # height, half depth, half breadth of the vest
    [
        (0.500, 0.077, 0.109),
        (0.540, 0.076, 0.107),
        (0.600, 0.070, 0.100),
        (0.660, 0.071, 0.104),
        (0.720, 0.075, 0.112),
        (0.770, 0.070, 0.118),
        (0.800, 0.062, 0.116),
        (0.820, 0.052, 0.096),
        (0.838, 0.042, 0.060),
        (0.850, 0.038, 0.042),
    ]
)
_HIPS = ((0.465, 0.03, 0.05), (0.48, 0.06, 0.088), (0.52, 0.068, 0.097), (0.56, 0.064, 0.092))
_LEG = ((0.050, 0.045), (0.052, 0.046), (0.047, 0.043), (0.038, 0.036), (0.037, 0.035), (0.035, 0.033))
_ARM = (0.016, 0.034, 0.032, 0.028, 0.026, 0.022)
_DOME = ((0.0, 0.0), (0.53, 0.0), *((0.5 * np.cos(a), np.sin(a)) for a in np.linspace(0.12, 1.4, 6)), (0.0, 1.0))


@dataclass(frozen=True)
class Worker:
    """One person."""

    obj_id: int
    """Number of the standing geometry; the walking one follows."""
    stature: float
    """Height without shoes and helmet (m)."""
    girth: float
    """Breadth and depth of the body against those of a slim man."""
    mass: float
    """Kilograms, dressed."""
    vest: str
    """Material of the vest."""
    sleeves: str
    """Material of the sleeves."""
    trousers: str
    """Material of the trousers."""
    skin: str
    """Material of face and neck."""
    helmet: str
    """Material of the helmet."""


@dataclass(frozen=True)
class Pose:
    """Angles of the limbs in the vertical plane (deg), forwards positive; left, then right."""

    thighs: tuple[float, float]
    """Thighs against the vertical."""
    shanks: tuple[float, float]
    """Shanks against the vertical."""
    arms: tuple[float, float]
    """Upper arms against the vertical."""
    forearms: tuple[float, float]
    """Forearms against the vertical."""
    feet: tuple[float, float]
    """Feet against the floor, toes up positive."""
    lean: float = 0.0
    """Trunk, head and arms against the vertical, about the hips."""


@dataclass(frozen=True)
class Grain:
    """How finely the body is divided: shading is flat, so that a few facets are seen as facets."""

    limb: int
    """Corners of a section of a limb."""
    trunk: int
    """Corners of a section of the trunk."""
    block: tuple[int, int]
    """Points around a rounded block and bands from pole to pole."""
    between: int
    """Sections put between each two that are given, along smooth curves."""


PLAIN = Grain(16, 28, (24, 8), 0)
"""As few as will do from afar."""
FINE = Grain(36, 64, (56, 24), 3)
"""Facets of some 8 mm, about a pixel of a camera with 800 px focal length at 6 m."""


class Figure:
    """Parts and boxes of one worker who stands on z = 0 and faces +x."""

    def __init__(self, worker: Worker, pose: Pose, grain: Grain = PLAIN) -> None:
        self._grain = grain
        self.worker, self._h, self._hg = worker, worker.stature, worker.stature * worker.girth
        self.parts: list[Part] = []
        self.boxes: list[OrientedBox] = []
        legs = [self._leg(side, pose, number) for number, side in enumerate((1.0, -1.0))]
        # The hips are as high as the lower foot lets them be.
        hip = -min(float(part.placed().vertices[:, 2].min()) for parts, _ in legs for part in parts)
        self.hip = hip
        """Height of the hip joints over the lowest point of the legs (m)."""
        for leg in legs:
            self._add(leg, make_transform(translation=np.array([0.0, 0.0, hip])))
        T = make_transform(translation=np.array([0.0, 0.0, hip - _HIP * self._h]))
        if pose.lean:
            T_hip = make_transform(rotation_y(np.deg2rad(pose.lean)), np.array([0.0, 0.0, hip]))
            T = T_hip @ make_transform(translation=np.array([0.0, 0.0, -_HIP * self._h]))
        for piece in (self._trunk(), self._head(), self._arm(1.0, pose, 0), self._arm(-1.0, pose, 1)):
            self._add(piece, T)
            if pose.lean and len(piece[1]) == 1:
                # Upright, so that the model's own box cuts it where it stands out, and does not thin it.
                corners = self.boxes.pop().corners()
                low, high = corners.min(axis=0), corners.max(axis=0)
                self.boxes.append(OrientedBox(make_transform(translation=(low + high) / 2), high - low))

    def _add(self, piece: Piece, T: Transform) -> None:
        self.parts += [_moved(part, T) for part in piece[0]]
        self.boxes += [OrientedBox(T @ box.T_parent_box, box.size) for box in piece[1]]

    def _leg(self, side: float, pose: Pose, number: int) -> Piece:
        """Return trouser leg and shoe, with the hip at z = 0."""
        h = self._h
        hip = np.array([0.0, side * 0.054 * h, 0.0])
        knee = hip + 0.245 * h * _down(pose.thighs[number]) + np.array([0.0, side * 0.002 * h, 0.0])
        ankle = knee + 0.246 * h * _down(pose.shanks[number]) + np.array([0.0, side * 0.003 * h, 0.0])
        above = hip + np.array([0.0, 0.0, 0.02 * h])
        hem = ankle + 0.012 * h * _down(pose.shanks[number])
        path = np.array([above, hip, (hip + knee) / 2, knee, knee + 0.35 * (ankle - knee), hem])
        trouser = mesh_part(self._tube(path, np.array(_LEG) * self._hg), self.worker.trousers)
        shoe, boxes = self._shoe(ankle, pose.feet[number])
        bent = 0.022 * h if self._grain.between else 0.0
        limbs = [limb_box(hip, knee, 0.049 * self._hg, bent), limb_box(knee, ankle, 0.039 * self._hg)]
        return [trouser, *shoe], [*limbs, *boxes]

    def _shoe(self, ankle: Vector, pitch: float) -> Piece:
        """Return a safety shoe under ``ankle``: sole, upper and collar, turned by ``pitch`` (deg, toes up)."""
        h = self._h
        length, width, sole = 0.152 * h + 0.03, 0.055 * h + 0.012, -0.039 * h
        middle = 0.5 * length - 0.055 * h
        T_ankle = make_transform(rotation_y(-np.deg2rad(pitch)), ankle)
        around, bands = self._grain.block
        upper = (0.97 * length, 0.94 * width, 0.08)
        parts = [
            solid_part(
                superellipsoid(3.0, 6.0, around, 4), (length, width, SOLE), (middle, 0.0, sole - SOLE / 2), "rubber"
            ),
            solid_part(superellipsoid(3.0, 2.5, around, bands), upper, (middle, 0.0, sole + 0.014), "mast_black"),
            self._block(2.5, 3.0, (0.068, 0.055, 0.075), (-0.01, 0.0, 0.0), "mast_black"),
        ]
        T_box = make_transform(translation=np.array([middle, 0.0, sole - SOLE + 0.05]))
        box = OrientedBox(T_ankle @ T_box, np.array([length, width, 0.10]))
        return [_moved(part, T_ankle) for part in parts], [box]

    def _trunk(self) -> Piece:
        """Return hips, vest, bands and neck; the floor lies at z = 0 for someone without shoes."""
        h, worker = self._h, self.worker
        hips = self._tube(
            np.array([(0.0, 0.0, z * h) for z, _, _ in _HIPS]),
            np.array(_HIPS)[:, 1:] * self._hg,
            max(24, self._grain.limb),
        )
        vest = self._around(_TRUNK[:, 0])
        neck_path = np.array([(0.005 * h, 0.0, _NECK * h), (0.012 * h, 0.0, 0.89 * h)])
        neck = tube(neck_path, [(0.036 * h, 0.036 * h)] * 2, sides=self._grain.limb)
        parts = [mesh_part(hips, worker.trousers), mesh_part(vest, worker.vest), mesh_part(neck, worker.skin)]
        parts += [mesh_part(band, "reflective") for band in self._bands()]
        box = limb_box((0.0, 0.0, 0.47 * h), (0.0, 0.0, 0.82 * h), 1.0)
        size = np.array([0.15 * self._hg, 0.23 * self._hg, box.size[2]])
        return parts, [OrientedBox(box.T_parent_box, size)]

    def _tube(
        self, path: Float[np.ndarray, "n 3"], radii: Float[np.ndarray, "n 2"], sides: int | None = None
    ) -> TriangleMesh:
        """Return a body along ``path`` (m), with sections in between where the grain is fine."""
        dense = smoothed(np.column_stack([path, radii]), self._grain.between)
        return tube(dense[:, :3], dense[:, 3:], sides=sides or self._grain.limb)

    def _around(self, fraction: Float[np.ndarray, " n"], standoff: float = 0.0) -> TriangleMesh:
        """Return the trunk between heights given as fractions of stature, ``standoff`` (m) of the vest."""
        depth, breadth = self._trunk_radii(fraction)
        path = np.array([(0.0, 0.0, z * self._h) for z in fraction])
        return self._tube(path, np.column_stack([depth, breadth]) + standoff, self._grain.trunk)

    def _trunk_radii(
        self, fraction: Float[np.ndarray, " n"]
    ) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
        """Return half depth and half breadth (m) of the vest at heights given as fractions of stature."""
        profile = smoothed(_TRUNK, self._grain.between)
        depth, breadth = (self._hg * np.interp(fraction, profile[:, 0], profile[:, column]) for column in (1, 2))
        return depth, breadth

    def _bands(self) -> list[TriangleMesh]:
        """Return two bands around the trunk and one over each shoulder, 4 mm proud of the vest."""
        h, standoff = self._h, 0.004
        bands = [self._around(middle + np.linspace(-0.5, 0.5, 3) * BAND / h, standoff) for middle in (0.575, 0.665)]
        y, up = 0.062 * h, np.linspace(0.69, 0.815, 8)
        depth, breadth = self._trunk_radii(up)
        x = depth * np.sqrt(np.clip(1.0 - (y / breadth) ** 2, 0.05, 1.0)) + 0.001
        front = np.column_stack([x, np.full(8, y), up * h])
        path = np.concatenate([front, front[::-1] * [-1.0, 1.0, 1.0]])
        for side in (1.0, -1.0):
            bands.append(tube(path * [1.0, side, 1.0], [(standoff, BAND / 2)] * len(path), sides=8))
        return bands

    def _head(self) -> Piece:
        """Return head, nose, ears, glasses and a helmet with its peak."""
        h, skin, helmet = self._h, self.worker.skin, self.worker.helmet
        x, z, eyes, brim = 0.018, 0.9325, 0.939, 1.0 + HELMET / h - 0.072
        parts = [
            self._block(2.2, 2.3, (0.112, 0.09, 0.135), (x, 0.0, z), skin),
            self._block(2.0, 2.0, (0.02, 0.018, 0.03), (x + 0.055, 0.0, eyes - 0.02), skin),
            self._block(2.0, 2.0, (0.025, 0.098, 0.036), (x - 0.004, 0.0, eyes - 0.015), skin),
            self._block(3.0, 3.0, (0.10, 0.086, 0.018), (x + 0.010, 0.0, eyes), "guard_black"),
            self._block(2.5, 4.0, (0.10, 0.105, 0.007), (x + 0.048, 0.0, brim + 0.0035), helmet),
            solid_part(
                lathe(_DOME, self._grain.block[0]), (0.142 * h, 0.118 * h, 0.072 * h), (x * h, 0.0, brim * h), helmet
            ),
        ]
        box = limb_box((0.025 * h, 0.0, _NECK * h), (0.025 * h, 0.0, h + HELMET), 1.0)
        return parts, [OrientedBox(box.T_parent_box, np.array([0.17 * h, 0.13 * h, box.size[2]]))]

    def _arm(self, side: float, pose: Pose, number: int) -> Piece:
        """Return sleeve and gloved hand."""
        h = self._h
        shoulder = np.array([0.0, side * 0.113 * self._hg, 0.795 * h])
        elbow = shoulder + 0.186 * h * _down(pose.arms[number]) + np.array([0.0, side * 0.022 * h, 0.0])
        wrist = elbow + 0.146 * h * _down(pose.forearms[number]) - np.array([0.0, side * 0.004 * h, 0.0])
        cap = shoulder + np.array([0.0, -side * 0.030 * h, 0.021 * h])
        path = np.array([cap, shoulder, (shoulder + elbow) / 2, elbow, (elbow + wrist) / 2, wrist])
        sleeve = self._tube(path, np.column_stack([_ARM, _ARM]) * self._hg)
        reach = 0.085 * h * _down(pose.forearms[number])
        along = np.array([wrist - 0.1 * reach, wrist + 0.25 * reach, wrist + 0.65 * reach, wrist + reach])
        hand = self._tube(along, np.array([(0.018, 0.011), (0.026, 0.016), (0.026, 0.016), (0.012, 0.007)]) * h)
        raised = 0.03 if self._grain.between else 0.015
        upper = limb_box(shoulder, elbow, 0.034 * self._hg, raised * h)
        lower = limb_box(elbow, wrist + reach, 0.028 * self._hg, 0.01 * h)
        return [mesh_part(sleeve, self.worker.sleeves), mesh_part(hand, "guard_black")], [upper, lower]

    def _block(self, side: float, profile: float, size: Triple, at: Triple, material: str) -> Part:
        """Return a rounded block whose size and place are fractions of stature."""
        mesh = superellipsoid(side, profile, *self._grain.block)
        return solid_part(mesh, self._h * np.asarray(size), self._h * np.asarray(at), material)


def _moved(part: Part, T: Transform) -> Part:
    return Part(part.mesh, part.scale, T @ part.T_object_part, part.material)


def _down(angle: float) -> Vector:
    """Return the unit vector that hangs down, swung forwards by ``angle`` (deg)."""
    turn = np.deg2rad(angle)
    return np.array([np.sin(turn), 0.0, -np.cos(turn)])


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
