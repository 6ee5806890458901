"""Recorded pallet faces with labels: reading them, and whether a fork that trusts an estimate would go in."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.dataset.files.image_io import decode_any_depth, decode_any_mask
from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.errors import InputError
from warehouse_sim.evaluation.docking.fork import HEEL_GAP, REACH, TINE_THICKNESS, TINE_WIDTH
from warehouse_sim.geometry.pose import Transform, invert, transform_points

POCKET_DEPTH = 1.10
"""The labelled pockets are taken to go on so far behind the face (m)."""
DEPTH_ERRORS = (-0.30, 0.05)
"""Along the insertion (m), positive too deep: too short a way is driven on by touch, too long a way pushes."""


@dataclass(frozen=True, eq=False)
class RecordedFace:
    """One frame and its labels."""

    name: str
    K: Float[np.ndarray, "3 3"]
    depth: Float[np.ndarray, "h w"]
    """Metres along the optical axis, 0 = none."""
    mask: Bool[np.ndarray, "h w"]
    color: Path
    T_camera_dock: Transform
    pockets: Float[np.ndarray, "2 3"]
    """Centres of the openings, right and left (dock frame, m)."""
    sizes: Float[np.ndarray, "2 2"]
    """Their widths and heights (m)."""
    gravity: Float[np.ndarray, " 3"]
    """Down (camera frame)."""


@dataclass(frozen=True)
class Entry:
    """What a fork would do."""

    docked: bool
    clearance_side: float
    """Least clearance beside the tines in the labelled pockets (m), negative where they hit."""
    clearance_up: float
    """The same above and below."""
    depth: float
    """Depth error (m), positive too deep."""
    lateral: float
    """Positive to the left (m)."""
    vertical: float
    """Positive too high (m)."""
    yaw_deg: float
    pitch_deg: float
    roll_deg: float


def read_faces(folder: Path) -> list[RecordedFace]:
    """Read all frames of the sites under a folder.

    Raises:
        InputError: It holds no labels, or malformed ones.
        DatasetError: An image cannot be read.
    """
    found = []
    for labels in sorted(folder.glob("*/labels.json")) or sorted(folder.glob("labels.json")):
        site = read_json(labels)
        try:
            found += [_read(labels.parent, np.array(site["K"], dtype=float), frame) for frame in site["frames"]]
        except (KeyError, TypeError, ValueError, IndexError) as problem:
            raise InputError(f"{labels}: is malformed ({problem!r}); docs/benchmark.md says what it holds") from problem
    if not found:
        raise InputError(f"{folder}: holds no labels.json, nor does a folder in it")
    return found


def _read(folder: Path, K: Float[np.ndarray, "3 3"], frame: dict) -> RecordedFace:
    depth, mask = decode_any_depth(folder / frame["depth"]), decode_any_mask(folder / frame["mask"])
    T = np.array(frame["T_camera_dock"], dtype=float)
    centres = transform_points(invert(T), np.array(frame["pocket_centres_m"]))
    order = np.argsort(centres[:, 1])
    return RecordedFace(
        f"{folder.name}/{frame['frame']:03d}",
        K,
        depth.astype(np.float32) / 1000.0,
        mask,
        folder / frame["rgb"],
        T,
        centres[order],
        np.array(frame["pocket_size_m"])[order],
        np.array(frame["gravity"]) / np.linalg.norm(frame["gravity"]),
    )


def drive_in(
    face: RecordedFace,
    T_camera_dock: Transform,
    pockets: Sequence[Float[np.ndarray, " 2"]] | None,
) -> Entry:
    """Return what a fork would do that trusts an estimate.

    Args:
        face: The ground truth.
        T_camera_dock: The estimated dock frame.
        pockets: Where the estimate has the pockets' centres (y and z of its dock frame, m); None puts the tines as far
            apart as the labelled pockets are.
    """
    T = invert(face.T_camera_dock) @ T_camera_dock
    aims = face.pockets[:, 1:] if pockets is None else sorted(pockets, key=lambda item: item[0])
    side, up = np.inf, np.inf
    # Straight edges in a straight prism: steps of 5 mm find the least clearance to a fraction of a millimetre.
    x = np.arange(-HEEL_GAP, REACH + 1e-9, 0.005)
    for aim, centre, size in zip(aims, face.pockets, face.sizes, strict=True):
        for y, z in ((-0.5, -0.5), (-0.5, 0.5), (0.5, 0.5), (0.5, -0.5)):
            edge = np.column_stack(
                [x, np.full_like(x, aim[0] + y * TINE_WIDTH), np.full_like(x, aim[1] + z * TINE_THICKNESS)]
            )
            swept = transform_points(T, edge)
            swept = swept[(swept[:, 0] >= 0.0) & (swept[:, 0] <= POCKET_DEPTH)]
            if len(swept) == 0:
                return Entry(False, -np.inf, -np.inf, *_errors(T))
            clearance = size / 2.0 - np.abs(swept[:, 1:] - centre[1:])
            side, up = min(side, float(clearance[:, 0].min())), min(up, float(clearance[:, 1].min()))
    low, high = DEPTH_ERRORS
    return Entry(bool(side >= 0.0 and up >= 0.0 and low <= T[0, 3] <= high), side, up, *_errors(T))


def _errors(T: Transform) -> tuple[float, ...]:
    turns = np.arctan2(T[1, 0], T[0, 0]), np.arcsin(np.clip(T[2, 0], -1.0, 1.0)), np.arctan2(T[2, 1], T[2, 2])
    return (*T[:3, 3].tolist(), *np.rad2deg(turns).tolist())
