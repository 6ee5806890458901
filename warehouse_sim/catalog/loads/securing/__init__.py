"""What goes under and around a load: slip sheets, corner posts and stretch film.

Slip sheets of kraft board are 0.6-1.5 mm thick; as a layer on a pallet they have its size and no tabs. Corner posts are
angles of laminated board, commonly 50 x 50 mm and 3-6 mm thick. Solid board weighs about 700-800 kg/m^3.

Stretch film lies in overlapping bands of a spiral, with the edge of the last one folded over the top. Machine film is
500 mm wide and wound with half its width over the turn before, stronger at foot and top. Its thickness of 17-23
micrometres is sampled as half a millimetre. The film is made to measure: every load has its own shell, all of them
under one obj_id. Film tints what lies behind it and has no depth and no pixels of its own in instance masks, since its
material's opacity is below 1; its id, class and pose are in the scene record like those of everything else.
"""

import zlib
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog.loads.securing.film_skin import Level
from warehouse_sim.catalog.parts import box_part, collision_boxes, mesh_part, model_of, slab_part
from warehouse_sim.geometry.convex import grown
from warehouse_sim.geometry.mesh import TriangleMesh, merge
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import ObjectModel

SHEET = 0.0015
"""Thickness of a slip sheet (m)."""
POST_LEG, POST_BOARD = 0.05, 0.004
"""Width of a post's legs and thickness of its board (m)."""
_DENSITY = 750.0

SLIP_SHEETS = {
    f"slip_sheet_{round(1000 * length)}x{round(1000 * width)}": (obj_id, length, width)
    for obj_id, length, width in ((40, 1.2, 0.8), (41, 1.2, 1.0), (42, 1.219, 1.016), (43, 0.8, 0.6))
}
"""Catalog name -> obj_id, length and width (m)."""
CORNER_POSTS = {
    f"corner_post_{round(1000 * h)}": (44 + i, h) for i, h in enumerate(np.round(np.arange(0.3, 1.75, 0.1), 3))
}
"""Catalog name -> obj_id and height (m)."""


def slip_sheet(name: str) -> ObjectModel:
    """Build the sheet called ``name`` ("slip_sheet_1200x800")."""
    obj_id, length, width = SLIP_SHEETS[name]
    size = (length, width, SHEET)
    sheet = box_part(size, (0.0, 0.0, 0.0), "kraft_dark")
    return model_of(
        name,
        "slip_sheet",
        obj_id,
        size,
        (sheet,),
        collision_boxes((sheet,)),
        mass=_DENSITY * length * width * SHEET,
        symmetry=SymmetryGroup.cuboid(),
    )


def corner_post(name: str) -> ObjectModel:
    """Build the post called ``name`` ("corner_post_1000"); its corner is at -x -y and its legs reach to +x and +y.

    It has no collision boxes: the wrap holds it, so it stands where the load's corner is.
    """
    obj_id, height = CORNER_POSTS[name]
    half, board = POST_LEG / 2, POST_BOARD
    outline = ((-half, -half), (half, -half), (half, board - half), (board - half, board - half), (board - half, half),
               (-half, half))  # fmt: skip
    return model_of(
        name,
        "corner_post",
        int(obj_id),
        (POST_LEG, POST_LEG, height),
        (slab_part(outline, -height / 2, height / 2, "board_white"),),
        (),
        mass=_DENSITY * float(height) * board * (2 * POST_LEG - board),
    )


OBJ_ID = 60
FILM_WIDTH, OVERLAP = 0.5, 0.2
"""Width of the film and how far it lies over the turn below (m)."""
_THICK, _STEP = 0.0005, 0.0008
"""Drawn thickness of the film and distance from one turn to the turn over it (m)."""
_FOLD = 0.07
"""How far the film reaches over the edge of the top (m)."""


WRAPS = {"wrap_1200x800x1000": (1.2, 0.8, 1.0)}
"""Catalog name -> edges (m) of the block that the film goes around: the one shell that is not made for a load."""


def wrap(name: str) -> ObjectModel:
    """Build the shell called ``name`` ("wrap_1200x800x1000")."""
    length, width, height = WRAPS[name]
    outline = np.array([[-length, -width], [length, -width], [length, width], [-length, width]]) / 2
    return replace(stretch_wrap([Level(outline, 0.0, height)])[0], name=name)


def stretch_wrap(levels: Sequence[Level]) -> tuple[ObjectModel, Float[np.ndarray, " 3"]]:
    """Return film around ``levels``, given from the ground up, and where its centre lies in their frame (m).

    The film has no collision boxes: it follows the goods and is not pushed by them.
    """
    bands = [band for level in levels for band in _bands(level)]
    mesh = merge([*bands, _fold(levels[-1])])
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    centre = (low + high) / 2
    centred = TriangleMesh(mesh.vertices - centre, mesh.faces)
    size = high - low
    tag = zlib.crc32(np.round(centred.vertices, 6).tobytes())
    model = model_of(f"wrap~{tag:08x}", "wrap", OBJ_ID, size, (mesh_part(centred, "stretch_film"),), (), mass=0.25)
    return model, centre


def _bands(level: Level) -> list[TriangleMesh]:
    """Return the turns of film around one level; every second one lies over its neighbours."""
    rise = level.high - level.low
    count = max(1, int(np.ceil((rise - OVERLAP) / (FILM_WIDTH - OVERLAP))))
    width = (rise + (count - 1) * OVERLAP) / count
    starts = level.low + np.arange(count) * (width - OVERLAP)
    return [
        _tube(
            grown(level.outline, _STEP * (turn % 2)),
            float(z),
            grown(level.outline, _STEP * (turn % 2)),
            float(z + width),
        )
        for turn, z in enumerate(starts)
    ]


def _fold(level: Level) -> TriangleMesh:
    """Return the strip that lies on the top of the load, from its edge inwards."""
    outline = level.outline
    middle = outline.mean(axis=0)
    edges = np.roll(outline, -1, axis=0) - outline
    normals = np.column_stack([edges[:, 1], -edges[:, 0]]) / np.linalg.norm(edges, axis=1, keepdims=True)
    reach = float(((outline - middle) * normals).sum(axis=1).min())
    inner = middle + (outline - middle) * max(0.4, 1.0 - _FOLD / reach)
    return _tube(outline, level.high, inner, level.high + _THICK)


def _tube(
    low_outline: Float[np.ndarray, "n 2"], low: float, high_outline: Float[np.ndarray, "n 2"], high: float
) -> TriangleMesh:
    """Return a thin closed shell between two outlines at two heights (m); its inner face is the outlines'."""
    count = len(low_outline)
    rings = [
        (grown(low_outline, _THICK), low),
        (grown(high_outline, _THICK), high),
        (high_outline, high),
        (low_outline, low),
    ]
    vertices = np.concatenate([np.column_stack([ring, np.full(count, z)]) for ring, z in rings])
    index = np.arange(4 * count).reshape(4, count)
    after = np.roll(index, -1, axis=1)
    up, up_after = np.roll(index, -1, axis=0), np.roll(after, -1, axis=0)
    faces = np.concatenate([np.stack([index, after, up_after], -1), np.stack([index, up_after, up], -1)])
    return TriangleMesh(vertices, faces.reshape(-1, 3).astype(np.int32))
