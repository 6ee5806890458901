"""Faces of pallets that are in no catalog, made of boxes and read by a time-of-flight camera with its errors.

Frames of recorded sites are few, and what is tuned to them says nothing of other sites. These are made without the
scenes, sensors and catalog of the package: pallets of wood and plastic with random measures, on floors, stacks and
racks, with loads, neighbours and cut-off ends, and errors as large as those that recordings show. Their ground truth
is exact.
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import trimesh
from jaxtyping import Bool, Float
from scipy.ndimage import gaussian_filter, maximum_filter, minimum_filter

from warehouse_sim.benchmark.recorded.faces import RecordedFace
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transform, invert, make_transform, rotation_x, rotation_y, rotation_z
from warehouse_sim.render.embree import PlacedMeshes

_SIZE_WH, _FOCAL_PX = (640, 480), 462.6
"""Of the camera whose errors are copied."""
_SIGMA_M = ((0.5, 1.0, 1.5, 2.0, 3.0), (0.007, 0.015, 0.016, 0.022, 0.040))
"""Deviation of a reading in time (m), by distance (m): measured on recordings of such a camera."""
_BLUR_PX = 1.2
"""Of that noise: neighbours at 1, 2 and 3 px are correlated by about 0.8, 0.5 and 0.25."""
_R_CAMERA_DOCK = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
"""Axes of a face (x inwards, y left, z up) in those of a camera that looks at it."""


@dataclass
class _Made:
    """Boxes about a face: x inwards, y left, z up, the origin under its middle (m)."""

    pallet: list[Float[np.ndarray, "2 3"]] = field(default_factory=list)
    others: list[Float[np.ndarray, "2 3"]] = field(default_factory=list)
    floor: float = 0.0
    width: float = 0.0
    height: float = 0.0
    deep: float = 0.0
    pockets: Float[np.ndarray, "2 2"] = field(default_factory=lambda: np.zeros((2, 2)))
    """Middle of each opening (y, z), right and left."""
    clear: tuple[float, float] = (0.0, 0.0)


def made_face(index: int, seed: int) -> RecordedFace:
    """Make a face with mask and gravity, which its number decides; it is named ``SURROUNDINGS/NUMBER``."""
    rng = np.random.default_rng([seed, index])
    made = _pallet(rng)
    kind = _surroundings(made, rng)
    return _recorded(f"{kind}/{index:04d}", made, rng)


def _box(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> Float[np.ndarray, "2 3"]:
    return np.array([x, y, z]).T


def _pallet(rng: np.random.Generator) -> _Made:
    """Return a pallet of any measures: three rows of posts under a deck, with or without boards under them."""
    kind = rng.choice(["block", "plastic", "stringer"], p=[0.5, 0.3, 0.2])
    while True:
        width, deep = rng.uniform(0.75, 1.6 if kind == "plastic" else 1.3), rng.uniform(0.8, 1.2)
        if kind == "stringer":
            outer = middle = rng.uniform(0.035, 0.055)
        else:
            outer, middle = rng.uniform(0.07, 0.2), rng.uniform(0.09, 0.25)
        deck = rng.uniform(0.016, 0.05)
        board = rng.uniform(0.014, 0.026) if rng.random() < (0.8 if kind == "stringer" else 0.45) else 0.0
        tall = rng.uniform(0.078, 0.125)
        clear = (width - middle) / 2.0 - outer
        if 0.2 <= clear <= 0.52:
            break
    skid = board or (rng.uniform(0.0, 0.025) if rng.random() < 0.7 else 0.0)
    foot, top = skid, skid + tall
    back = rng.uniform(0.0, 0.05) if kind == "plastic" and rng.random() < 0.5 else abs(rng.normal(0.0, 0.004))
    made = _Made(width=width, deep=deep, height=top + deck, clear=(clear, top - board))
    lanes = [(-width / 2, -width / 2 + outer), (-middle / 2, middle / 2), (width / 2 - outer, width / 2)]
    rows = [(back, deep)] if kind == "stringer" else [
        (back, back + rng.uniform(0.1, 0.16)), (deep / 2 - 0.07, deep / 2 + 0.07), (deep - 0.14, deep)
    ]  # fmt: skip
    for y in lanes:
        made.pallet += [_box(x, y, (foot if skid and not board else 0.0, top)) for x in rows]
        if skid and not board:
            made.pallet.append(_box((abs(rng.normal(0, 0.004)), deep), y, (0.0, skid)))
    if board:
        for x in (0.0, deep / 2 - 0.05, deep - 0.1):
            made.pallet.append(_box((x, x + 0.1), (-width / 2, width / 2), (0.0, board)))
    # The deck: whole, or of boards across the face, the first of which is the face's upper border.
    if kind == "plastic" or rng.random() < 0.4:
        made.pallet.append(_box((0.0, deep), (-width / 2, width / 2), (top, top + deck)))
    else:
        step = rng.uniform(0.11, 0.19)
        for x in np.arange(0.0, deep - 0.08, step):
            made.pallet.append(_box((x, x + 0.09), (-width / 2, width / 2), (top, top + deck)))
    up, aside = (board + top) / 2.0, (middle + clear) / 2.0
    made.pockets = np.array([[-aside, up], [aside, up]])
    return made


def _surroundings(made: _Made, rng: np.random.Generator) -> str:
    """Put the pallet somewhere, with what stands about it, and return where."""
    kind = str(rng.choice(["floor", "stack", "rack"], p=[0.5, 0.2, 0.3]))
    if kind == "stack":
        _stack(made, rng)
    elif kind == "rack":
        _rack(made, rng)
    if rng.random() < 0.75:
        _load(made, 0.0, rng)
    for side in (-1.0, 1.0):
        if rng.random() < 0.35:
            aside = side * (made.width + rng.uniform(0.06, 0.35))
            forward = rng.normal(0.0, 0.04)
            made.others += [box + np.array([forward, aside, 0.0]) for box in made.pallet]
            if rng.random() < 0.7:
                _load(made, aside, rng, forward)
    if rng.random() < 0.7:
        away = made.deep + rng.uniform(0.05, 4.0)
        made.others.append(_box((away, away + 0.1), (-6.0, 6.0), (made.floor, 4.0)))
    for _ in range(rng.integers(0, 3)):
        x, y = rng.uniform(-0.3, 2.5), rng.choice([-1, 1]) * rng.uniform(made.width / 2 + 0.5, 2.5)
        long, wide = rng.uniform(0.1, 0.8), rng.uniform(0.1, 0.8)
        made.others.append(_box((x, x + long), (y, y + wide), (made.floor, made.floor + 1.0)))
    return kind


def _stack(made: _Made, rng: np.random.Generator) -> None:
    """Put the pallet on the load of another."""
    width, deep, below = made.width, made.deep, rng.uniform(0.4, 1.2)
    made.floor = -below - 0.14
    out = rng.uniform(-0.03, 0.06)
    made.others.append(_box((out, deep - out), (-width / 2 + 0.02, width / 2 - 0.02), (-below, 0.0)))
    made.others.append(_box((0.0, deep), (-width / 2, width / 2), (-below - 0.14, -below - 0.1)))


def _rack(made: _Made, rng: np.random.Generator) -> None:
    """Put the pallet on two beams between uprights."""
    width, deep = made.width, made.deep
    made.floor = -rng.uniform(0.15, 2.5)
    behind, tall = rng.uniform(0.0, 0.1), rng.uniform(0.09, 0.15)
    left, right = (width / 2 + rng.uniform(0.05, 0.4) for _ in range(2))
    for x in (behind, deep - behind - 0.05):
        made.others.append(_box((x, x + 0.05), (-right, left), (-tall, 0.0)))
        for y in (left, -right - 0.1):
            made.others.append(_box((x - 0.02, x + 0.08), (y, y + 0.1), (made.floor, 2.5)))
    if rng.random() < 0.5:
        above = made.height + rng.uniform(0.3, 1.6)
        made.others.append(_box((behind, behind + 0.05), (-right, left), (above, above + tall)))


def _load(made: _Made, aside: float, rng: np.random.Generator, forward: float = 0.0) -> None:
    """Put cartons on a pallet: flush, set back or over its edge."""
    out, wide, tall = rng.uniform(-0.03, 0.1), made.width * rng.uniform(0.8, 1.02), rng.uniform(0.2, 1.3)
    columns, layers = rng.integers(1, 5), rng.integers(1, 4)
    y, z = np.linspace(-wide / 2, wide / 2, columns + 1) + aside, np.linspace(0.0, tall, layers + 1) + made.height
    for i in range(columns):
        for j in range(layers):
            x = out + forward + rng.normal(0.0, 0.006)
            made.others.append(_box((x, made.deep - 0.02), (y[i] + 0.003, y[i + 1] - 0.003), (z[j], z[j + 1] - 0.002)))


def _place_camera(made: _Made, rng: np.random.Generator) -> Transform:
    """Return T_camera_made of a camera low on a truck that is about to drive in."""
    half = 0.5 * _SIZE_WH[0] / _FOCAL_PX
    least = 0.55 * made.width / half if rng.random() < 0.85 else 0.38 * made.width / half
    distance = rng.uniform(max(least, 0.6), max(least + 0.3, 2.1))
    yaw, roll = np.deg2rad(np.clip(rng.normal(0.0, 6.0), -18, 18)), np.deg2rad(rng.normal(0.0, 1.5))
    up, pitch = rng.uniform(0.0, 0.5), np.deg2rad(rng.normal(0.0, 3.0))
    if rng.random() < 0.15:  # higher up, it looks down
        up = rng.uniform(0.4, 0.8)
        pitch += np.deg2rad(rng.uniform(5.0, 20.0))
    # The camera stands on a circle about the face and looks at its middle, up to some centimetres.
    T_dock_level = make_transform(rotation_z(yaw), np.array([0.0, rng.normal(0.0, 0.06), 0.0]))
    T_level_camera = np.eye(4)
    T_level_camera[:3, :3] = rotation_y(pitch) @ rotation_x(roll) @ _R_CAMERA_DOCK.T
    T_level_camera[:3, 3] = [-distance, 0.0, up]
    return invert(T_dock_level @ T_level_camera)


def _recorded(name: str, made: _Made, rng: np.random.Generator) -> RecordedFace:
    T_camera_made = _place_camera(made, rng)
    T_made_camera = invert(T_camera_made)
    width, height = _SIZE_WH
    K = np.array([[_FOCAL_PX, 0.0, (width - 1) / 2], [0.0, _FOCAL_PX, (height - 1) / 2], [0.0, 0.0, 1.0]])
    v, u = np.mgrid[:height, :width].reshape(2, -1).astype(float)
    rays = np.column_stack([(u - K[0, 2]) / _FOCAL_PX, (v - K[1, 2]) / _FOCAL_PX, np.ones_like(u)])
    floor = _box((-6.0, 8.0), (-8.0, 8.0), (made.floor - 0.1, made.floor))
    boxes = [*made.pallet, *made.others, floor]
    meshes = PlacedMeshes([[_mesh(box) for box in boxes]], [(0, np.eye(4))])
    hits = meshes.cast(np.tile(T_made_camera[:3, 3], (len(rays), 1)), rays @ T_made_camera[:3, :3].T)
    exact = np.where(hits.place < 0, 0.0, hits.distance).reshape(height, width).astype(float)
    piece = np.where(hits.place < 0, -1, hits.piece).reshape(height, width)
    steep = np.abs(np.einsum("ij,ij->i", hits.normal, rays @ T_made_camera[:3, :3].T))
    steep /= np.maximum(np.linalg.norm(hits.normal, axis=1) * np.linalg.norm(rays, axis=1), 1e-9)
    depth = _read(exact, piece, piece == len(boxes) - 1, steep.reshape(height, width), rng)
    mask = _mask_by_hand((piece >= 0) & (piece < len(made.pallet)), rng)
    middle = made.pockets.mean(axis=0)
    T_camera_dock = T_camera_made @ make_transform(np.eye(3), np.array([0.0, *middle]))
    pockets = np.column_stack([np.zeros(2), made.pockets - middle])
    down = T_camera_made[:3, :3] @ [0.0, 0.0, -1.0]
    size = np.tile(made.clear, (2, 1))
    return RecordedFace(name, K, depth, mask, Path(name), T_camera_dock, pockets, size, down)


def _mesh(box: Float[np.ndarray, "2 3"]) -> TriangleMesh:
    mesh = trimesh.creation.box(bounds=box)
    return TriangleMesh(np.asarray(mesh.vertices), np.asarray(mesh.faces))


def _read(
    exact: Float[np.ndarray, "h w"],
    piece: np.ndarray,
    floor: Bool[np.ndarray, "h w"],
    steep: Float[np.ndarray, "h w"],
    rng: np.random.Generator,
) -> np.ndarray:
    """Return what the camera reads: noise, pattern, bend, mixed rims, mirrors, holes."""
    shape = exact.shape
    depth = exact.copy()
    kind = rng.choice(["matt", "glossy", "mirror"], p=[0.5, 0.3, 0.2])
    if kind == "mirror":
        depth[floor] *= rng.uniform(0.45, 0.8)
    elif kind == "glossy":
        reach = rng.uniform(0.1, 0.4)
        depth[floor & (rng.random(shape) > steep / reach)] = 0.0
    # Light on detours: what lies in hollows reads nearer than it is.
    near = minimum_filter(np.where(exact > 0, exact, np.inf), 31)
    hollow = np.where(np.isfinite(near) & (exact > 0), exact - near, 0.0)
    depth -= rng.uniform(0.0, 0.05) * (1.0 - np.exp(-hollow / 0.3)) * (depth > 0)
    sigma = np.interp(exact, *_SIGMA_M) * rng.uniform(0.6, 1.4, piece.max() + 2)[piece]
    depth = np.where(depth > 0, depth + _noise(shape, _BLUR_PX, rng) * sigma, 0.0)
    pattern = rng.uniform(0.003, 0.010) * _noise(shape, 2.0, rng)
    pattern += rng.uniform(0.005, 0.025) * _noise(shape, rng.uniform(15.0, 60.0), rng)
    depth = np.where(depth > 0, depth + pattern + rng.normal(0.0, 0.01), 0.0)
    low = minimum_filter(np.where(exact > 0, exact, np.inf), 3)
    high = maximum_filter(np.where(exact > 0, exact, 9.0), 3)
    rim = (high - low > 0.06) & np.isfinite(low)
    mixed = rim & (rng.random(shape) < rng.uniform(0.15, 0.45))
    depth[mixed] = low[mixed] + rng.random(shape)[mixed] * np.minimum(high[mixed] - low[mixed], 1.5)
    depth[rim & (rng.random(shape) < rng.uniform(0.0, 0.05))] = 0.0
    depth[rng.random(shape) < rng.uniform(0.0, 0.02)] = 0.0
    depth[exact > rng.uniform(2.5, 5.0)] = 0.0
    return np.maximum(depth, 0.0).astype(np.float32)


def _noise(shape: tuple[int, int], blur: float, rng: np.random.Generator) -> Float[np.ndarray, "h w"]:
    """Return noise of deviation 1 whose neighbours are correlated."""
    found = gaussian_filter(rng.normal(size=shape), blur, mode="reflect")
    return np.asarray(found / found.std())


def _mask_by_hand(exact: Bool[np.ndarray, "h w"], rng: np.random.Generator) -> Bool[np.ndarray, "h w"]:
    """Return a mask whose outline wanders by a pixel or so."""
    wander = gaussian_filter(exact.astype(float), 1.0) + 0.5 * gaussian_filter(rng.normal(size=exact.shape), 4.0)
    return np.asarray(wander > 0.5)
