"""A scene as flat arrays of parts, one row a part, those of one mesh together, and the rows of each object."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float, Float64, Int

from warehouse_sim.catalog.building.outdoors import OUTDOORS
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.camera import PinholeCamera, ViewPyramid
from warehouse_sim.geometry.mesh import TriangleMesh, unit_box
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.render.coarse_scene import JOINED_GOODS
from warehouse_sim.render.raster.projection import NEAR
from warehouse_sim.render.textures import WOUND, edge_order, texture_shift
from warehouse_sim.schema import Material, ObjectInstance, ObjectModel, Part, SceneSpec

_STEPS = 32_700.0
"""Of a place from the middle of a part's box to a face of it, as ``fine.glsl`` packs them."""
_SKIN = 0.0015
"""What reaches no farther than this out of a box (m) has no shadow that a map would show."""
_PRINT = ("print_", "label_", "board_face", "tape", "strap", "brand_mark")
"""How materials are called that lie on something else, which has the shadow."""


def shadow_casters(model: ObjectModel, materials: dict[str, Material]) -> Bool[np.ndarray, " n"]:
    """Return the parts of ``model`` that cast shadows: neither film nor skin on a box that casts one itself.

    Nothing outdoors does: no light stands there, and a dome around all would take the resolution of every map.
    """
    if model.class_name == OUTDOORS:
        return np.zeros(len(model.parts), dtype=bool)
    casts = np.array([materials[part.material].opacity >= 1.0 for part in model.parts])
    printed = np.array([part.material.startswith(_PRINT) for part in model.parts])
    if not printed.all():
        casts &= ~printed
    boxes = [number for number, part in enumerate(model.parts) if casts[number] and part.mesh is unit_box()]
    corners = _corners(model)
    # From the largest box on, so that of two boxes in the same place one stays.
    for box in sorted(boxes, key=lambda number: -float(np.prod(model.parts[number].scale))):
        if casts[box]:
            part = model.parts[box]
            inside = (corners - part.T_object_part[:3, 3]) @ part.T_object_part[:3, :3]
            skin = (np.abs(inside) <= part.scale / 2 + _SKIN).all(axis=(1, 2))
            skin[box] = False
            casts &= ~skin
    return casts


def _corners(model: ObjectModel) -> Float[np.ndarray, "n 8 3"]:
    """Return the corners of each part's bounding box in the object frame (m)."""
    extent = {part.mesh: (part.mesh.vertices.min(axis=0), part.mesh.vertices.max(axis=0)) for part in model.parts}
    low, high = (np.stack([extent[part.mesh][side] * part.scale for part in model.parts]) for side in (0, 1))
    local = (low + high)[:, None] / 2 + box_corners(np.ones(3)) * (high - low)[:, None]
    T = np.stack([part.T_object_part for part in model.parts])
    return np.einsum("nij,nkj->nki", T[:, :3, :3], local) + T[:, None, :3, 3]


# What a vertex shader reads once an instance; the order of fields is that of ``INSTANCE_FORMAT``.
INSTANCE = np.dtype(
    [
        ("rotation", "f4", (3, 3)),  # columns first, as GLSL stores a mat3
        ("translation", "f4", 3),
        ("scale", "f4", 3),
        ("texture_shift", "f4", 2),
        # Instance id, material row, edge order as first + 4 second + 16 third with the edges' lengths, thinnest axis.
        ("identity", "i4", 4),
        ("spread", "f4", 3),  # steps of ``fine.glsl`` between the faces of the part's box: a unit of position
        ("start", "f4", 3),  # and at position 0
        ("picture", "f4", 4),  # least place along the picture's axes (m), and pictures a metre along them
    ]
)
INSTANCE_FORMAT = "9f4 3f4 3f4 2f4 4i4 3f4 3f4 4f4/i"


@dataclass(frozen=True, eq=False)
class PartTable:
    """Every part of every object of a scene."""

    meshes: tuple[TriangleMesh, ...]
    rows_of_mesh: tuple[slice, ...]
    """Rows that draw each of ``meshes``."""
    film: Bool[np.ndarray, " n"]
    """Rows whose material lets light through: they tint the image, and leave depth, instance masks and shadows
    alone."""
    painted: Bool[np.ndarray, " n"]
    """Rows that leave paint in the geometry buffer: those whose material has a picture or is a ribbed sheet's."""
    casts: Bool[np.ndarray, " n"]
    """Rows that cast shadows."""
    filled: tuple[bool, ...]
    """For each of ``meshes`` whether it is goods of a load joined into one object, whose insides nobody sees."""
    T_world_part: Float64[np.ndarray, "n 4 4"]
    local_centre: Float64[np.ndarray, "n 3"]
    """Centre of each part's bounding box in the part's frame (m)."""
    half_size: Float64[np.ndarray, "n 3"]
    """Half edge lengths of that box (m)."""
    template: np.ndarray
    """(n,) of dtype ``INSTANCE``; all but the placement is filled in."""

    def __len__(self) -> int:
        return len(self.template)

    @property
    def radius(self) -> Float64[np.ndarray, " n"]:
        """Radius of a sphere about the centre that holds the part (m)."""
        return np.linalg.norm(self.half_size, axis=1)

    def centres(self, records: np.ndarray) -> Float64[np.ndarray, "n 3"]:
        """Return the centres of the parts' boxes in the frame in which ``records`` places them (m)."""
        return np.einsum("nji,nj->ni", records["rotation"], self.local_centre) + records["translation"]

    def subset(self, rows: Int[np.ndarray, " k"]) -> "PartTable":
        """Return the table of some rows only; ``rows`` rise. Meshes that no row is left of stay, with none."""
        ends = np.searchsorted(rows, [0, *(group.stop for group in self.rows_of_mesh)])
        return PartTable(
            meshes=self.meshes,
            rows_of_mesh=tuple(slice(int(a), int(b)) for a, b in pairwise(ends)),
            film=self.film[rows],
            painted=self.painted[rows],
            casts=self.casts[rows],
            filled=self.filled,
            T_world_part=self.T_world_part[rows],
            local_centre=self.local_centre[rows],
            half_size=self.half_size[rows],
            template=self.template[rows],
        )

    def mesh_of(self, rows: Int[np.ndarray, " k"]) -> Int[np.ndarray, " k"]:
        """Return the number of the mesh of each of ``rows``."""
        return np.searchsorted([group.stop for group in self.rows_of_mesh], rows, side="right")

    def runs(self, rows: Int[np.ndarray, " k"]) -> Iterator[tuple[int, Int[np.ndarray, " r"]]]:
        """Cut ``rows``, at least one, where the mesh changes; yield the number of the mesh and its rows."""
        mesh_of = self.mesh_of(rows)
        cuts = np.flatnonzero(np.diff(mesh_of)) + 1
        for first, run in zip([0, *cuts], np.split(rows, cuts), strict=True):
            yield int(mesh_of[first]), run

    def tops(self) -> Float64[np.ndarray, " n"]:
        """Return the world height of the highest point of each part's box (m)."""
        up = self.T_world_part[:, 2, :3]
        return (up * self.local_centre + np.abs(up) * self.half_size).sum(axis=1) + self.T_world_part[:, 2, 3]


def build_part_table(scene: SceneSpec, material_row: dict[str, int], ribbed: frozenset[str] = frozenset()) -> PartTable:
    """Flatten ``scene``.

    Args:
        scene: What to draw; see ``require_renderable``.
        material_row: Number of each material of the scene.
        ribbed: Names of those that ribbed sheets are made of.
    """
    groups = _parts_by_mesh(scene)
    entries = [entry for group in groups.values() for entry in group]
    ends = np.cumsum([0] + [len(group) for group in groups.values()])
    scale = np.stack([part.scale for _, _, part in entries])
    extent = {mesh: (mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)) for mesh in groups}
    low, high = (np.stack([extent[part.mesh][side] for _, _, part in entries]) * scale for side in (0, 1))
    casts_of = {name: shadow_casters(scene.models[name], scene.materials) for name in {i.model for i, _, _ in entries}}
    ids = np.array([instance.instance_id for instance, _, _ in entries])
    paints = [instance.material_of(part) for instance, _, part in entries]
    template = np.zeros(len(entries), INSTANCE)
    template["scale"] = scale
    template["identity"][:, 0] = ids
    template["identity"][:, 1] = [material_row[paint] for paint in paints]
    wound = np.array([scene.materials[paint].texture == WOUND for paint in paints])
    template["identity"][:, 2] = edge_order(high - low, wound) @ np.array([1, 4, 16])
    template["identity"][:, 3] = np.argmin(high - low, axis=1)
    template["texture_shift"] = texture_shift(ids, np.array([number for _, number, _ in entries]))
    half = np.maximum((high - low) / 2, 1e-6)
    template["identity"][:, 2] |= _length_codes(half) @ np.array([1 << 6, 1 << 14, 1 << 22])
    template["spread"], template["start"] = _STEPS * scale / half, -_STEPS * (low + high) / 2 / half
    template["picture"] = _picture_frame(low, high)
    has_paint = {name: name in ribbed or item.picture is not None for name, item in scene.materials.items()}
    painted = np.array([has_paint[paint] for paint in paints])
    film = np.array([scene.materials[part.material].opacity < 1.0 for _, _, part in entries])
    joined = {name for name, model in scene.models.items() if model.class_name == JOINED_GOODS}
    T_world_object = np.stack([instance.T_world_object for instance, _, _ in entries])
    return PartTable(
        meshes=tuple(groups),
        rows_of_mesh=tuple(slice(a, b) for a, b in pairwise(ends)),
        film=film,
        painted=painted,
        casts=np.array([casts_of[instance.model][number] for instance, number, _ in entries]),
        filled=tuple(all(instance.model in joined for instance, _, _ in group) for group in groups.values()),
        T_world_part=T_world_object @ np.stack([part.T_object_part for _, _, part in entries]),
        local_centre=(low + high) / 2,
        half_size=(high - low) / 2,
        template=template,
    )


def placed_records(table: PartTable, T_world_camera: Transform) -> np.ndarray:
    """Return the whole table as instance records placed in the camera frame, computed in 64 bits."""
    T_camera_part = invert(T_world_camera) @ table.T_world_part
    records = table.template.copy()
    records["rotation"] = np.swapaxes(T_camera_part[:, :3, :3], 1, 2)
    records["translation"] = T_camera_part[:, :3, 3]
    return records


def _parts_by_mesh(scene: SceneSpec) -> dict[TriangleMesh, list[tuple[ObjectInstance, int, Part]]]:
    """Return, for each mesh, what draws it: the object, the number of the part in its model, the part."""
    groups: dict[TriangleMesh, list[tuple[ObjectInstance, int, Part]]] = {}
    for instance in scene.instances:
        for number, part in enumerate(scene.model_of(instance).parts):
            groups.setdefault(part.mesh, []).append((instance, number, part))
    return groups


def _length_codes(half: Float64[np.ndarray, "n 3"]) -> Int[np.ndarray, "n 3"]:
    """Return half edges (m) in sixteenths of an octave over 2^-10 m, 0-255: to 2 %, which no eye sees."""
    return np.clip(np.rint(16.0 * (np.log2(half) + 10.0)), 0, 255).astype(int)


def _picture_frame(low: Float64[np.ndarray, "n 3"], high: Float64[np.ndarray, "n 3"]) -> Float64[np.ndarray, "n 4"]:
    """Return where the picture of each part begins along its own two axes (m), and 1 over its edges there."""
    facing = np.argmin(high - low, axis=1)
    up = np.where(facing == 2, 1, 2)
    axes = np.stack([3 - facing - up, up], axis=1)
    start, end = (np.take_along_axis(side, axes, axis=1) for side in (low, high))
    return np.concatenate([start, 1.0 / np.maximum(end - start, 1e-6)], axis=1)


@dataclass(frozen=True, eq=False)
class ObjectIndex:
    """The objects of a part table, and a sphere around each, so that a view need not look at every part."""

    number: dict[int, int]
    """Place in the arrays below of each instance id."""
    rows: Int[np.ndarray, " n"]
    """All rows of the table, those of one object together, rising."""
    starts: Int[np.ndarray, " k1"]
    """Where in ``rows`` each object begins; one more at the end."""
    centre: Float64[np.ndarray, "k 3"]
    """World position of the middle of each sphere (m)."""
    radius: Float64[np.ndarray, " k"]
    """Its radius (m)."""

    @classmethod
    def of(cls, table: PartTable) -> "ObjectIndex":
        """Find the objects of ``table``."""
        ids, owner = np.unique(table.template["identity"][:, 0], return_inverse=True)
        rows = np.argsort(owner, kind="stable")
        starts = np.searchsorted(owner[rows], np.arange(len(ids) + 1))
        centres = (
            np.einsum("nij,nj->ni", table.T_world_part[:, :3, :3], table.local_centre) + table.T_world_part[:, :3, 3]
        )
        first, reach = starts[:-1], table.radius[:, None]
        low = np.minimum.reduceat((centres - reach)[rows], first)
        high = np.maximum.reduceat((centres + reach)[rows], first)
        middle = (low + high) / 2
        distance = np.linalg.norm(centres - middle[owner], axis=1) + table.radius
        radius = np.maximum.reduceat(distance[rows], first)
        return cls({int(key): k for k, key in enumerate(ids)}, rows, starts, middle, radius)

    def in_view(self, camera: PinholeCamera, T_world_camera: Transform) -> Int[np.ndarray, " k"]:
        """Return the rows, rising, of the objects that reach into the image or nearly do."""
        centre = transform_points(invert(T_world_camera), self.centre)
        touched = ViewPyramid.of(camera).touches(centre, self.radius, NEAR)
        return np.sort(self.rows[np.repeat(touched, np.diff(self.starts))])

    def rows_of(self, instance_ids: Sequence[int]) -> tuple[Int[np.ndarray, " k"], Int[np.ndarray, " k"]]:
        """Return the rows of some objects, rising, and for each the place of its owner in ``instance_ids``."""
        chosen = np.array([self.number[instance_id] for instance_id in instance_ids], int)
        counts = np.diff(self.starts)[chosen]
        within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        rows = self.rows[np.repeat(self.starts[chosen], counts) + within]
        owner = np.repeat(np.arange(len(chosen)), counts)
        order = np.argsort(rows, kind="stable")
        return rows[order], owner[order]
