"""The one traversal of the scene: instance ids, surface attributes and depth of the nearest surface of each pixel."""

from collections.abc import Sequence
from dataclasses import dataclass

import moderngl
import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.geometry.camera import PinholeCamera, ViewPyramid
from warehouse_sim.render.raster.context import assign, clear_to_zero, float_depth_texture, source
from warehouse_sim.render.raster.meshes.mesh_batch import MeshBatch, choose_levels
from warehouse_sim.render.raster.meshes.parts import PartTable
from warehouse_sim.render.raster.meshes.ribs import Ribs, ribs_of
from warehouse_sim.render.raster.passes.hidden_parts import DepthPyramid
from warehouse_sim.render.raster.projection import NEAR, WINDOW_PX, image_origin, window_intrinsics, window_viewport
from warehouse_sim.render.raster.surfaces import MaterialTable


class GeometryBuffer:
    """Render targets of one image size; what a pixel shows is stored, not yet how bright it is."""

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        self.size = size
        self.instance_mask = context.texture(size, 1, dtype="i4")
        self.surface = context.texture(size, 4, dtype="u4")
        self.reach = context.texture(size, 4)
        self.paint = context.texture(size, 4)
        self.exact_depth = context.texture(size, 1, dtype="f4")
        """As ``depth``, right to its rounding where interpolation is not."""
        self.depth = float_depth_texture(context, size)
        self.depth.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self.depth.compare_func = ""
        for texture in (self.instance_mask, self.surface, self.reach, self.exact_depth, self.paint):
            texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        colours = [self.instance_mask, self.surface, self.reach, self.exact_depth]
        self.target = context.framebuffer(colours, self.depth)
        # Most parts leave the paint as it is: their material says that there is none to read.
        self.painted = context.framebuffer([*colours, self.paint], self.depth)
        self.target.viewport = self.painted.viewport = window_viewport(size)

    def begin(self) -> None:
        """Bind and clear: no instance, infinitely far."""
        self.target.use()
        clear_to_zero(None, "f")
        clear_to_zero(0, "i")
        clear_to_zero(1, "ui")
        clear_to_zero(2, "f")
        clear_to_zero(3, "f")


_FINE = 64
"""Parts of more triangles are rendered last, and only where what is before them leaves room to see them."""
_LARGE = 4.0
"""Parts of this radius (m) and more, floors and walls, hide others and are not hidden: they keep their turn.

Where two surfaces are equally far the one that was rendered first stays, as on the edge of what stands on the floor."""
_WORTH_A_LOOK = 30_000
"""Least number of triangles of such parts for which the depth is read back."""
_LOOKS = 2
"""How often it is read: after all other parts, and after the nearer half of the fine ones."""
_KINDS = {"plain": ("plain.glsl", "plain.glsl"), "ribs": ("ribs.vert.glsl", "ribs.frag.glsl")}
_KINDS["picture"] = ("picture.vert.glsl", "picture.frag.glsl")
_PICTURES_UNIT = 1
_TRUSTED = 5e-4
"""Interpolated depth stays where it agrees with the plane of its face to this fraction."""


@dataclass(frozen=True, eq=False)
class _View:
    """What is rendered into which buffer."""

    target: GeometryBuffer
    table: PartTable
    records: np.ndarray
    """The table placed in the camera frame."""
    batches: Sequence[MeshBatch]
    levels: Int[np.ndarray, " n"]
    """Level of detail of each row."""
    far_end: Float[np.ndarray, " n"]
    """Greatest distance of each row's box along the axis (m)."""


class GeometryPass:
    """Draws a part table into a geometry buffer."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._programs = {
            kind: context.program(
                vertex_shader=source(
                    "place.glsl", "pack.glsl", "fine.glsl", "box_projection.glsl", vertex, "gbuffer.vert"
                ),
                fragment_shader=source("pack.glsl", "fine.glsl", fragment, "gbuffer.frag", TRUSTED=_TRUSTED),
            )
            for kind, (vertex, fragment) in _KINDS.items()
        }
        for program in self._programs.values():
            assign(program, near=NEAR, window=(WINDOW_PX, WINDOW_PX), materials=0, pictures=_PICTURES_UNIT)

    def draw(
        self,
        target: GeometryBuffer,
        camera: PinholeCamera,
        table: PartTable,
        records: np.ndarray,
        batches: Sequence[MeshBatch],
        materials: MaterialTable,
    ) -> None:
        """Draw all solid parts in view, the nearest first so that hidden ones cost only their depth test, or nothing.

        Args:
            target: Where to draw; its size is the camera's.
            camera: Intrinsics.
            table: The scene.
            records: The table placed in the camera frame.
            batches: One for each mesh of the table.
            materials: Supplies the texture scale and the pictures.
        """
        target.begin()
        self._prepare(camera, target.size, materials)
        centre, half_edges = table.centres(records), records["rotation"] * table.half_size[..., None]
        seen = ViewPyramid.of(camera).touches_boxes(centre, half_edges, NEAR) & ~table.film
        levels = choose_levels(table, [batch.errors for batch in batches], records, camera)
        # The far end orders better than the centre: a floor reaches under everything and should come last.
        far_end = centre[:, 2] + np.abs(half_edges[..., 2]).sum(axis=1)
        fine = np.zeros(len(table), int)
        for rows, batch in zip(table.rows_of_mesh, batches, strict=True):
            fine[rows] = batch.triangles[levels[rows]]
        view = _View(target, table, records, batches, levels, far_end)
        late = np.flatnonzero(seen & (fine > _FINE) & (table.radius < _LARGE))
        if fine[late].sum() < _WORTH_A_LOOK:
            self._draw_rows(view, seen)
            return
        seen[late] = False
        self._draw_rows(view, seen)
        for group in np.array_split(late[np.argsort(far_end[late], kind="stable")], _LOOKS):
            sampled = DepthPyramid.read(target.depth, target.size)
            chosen = np.zeros(len(table), bool)
            chosen[group[~sampled.hides(camera, table, records, group)]] = True
            self._draw_rows(view, chosen)

    def _draw_rows(self, view: "_View", wanted: Bool[np.ndarray, " n"]) -> None:
        """Draw the rows of a view that are ``wanted``, those without paint first."""
        target, table = view.target, view.table
        for rows_in, buffer in ((wanted & ~table.painted, target.target), (wanted & table.painted, target.painted)):
            rows = np.flatnonzero(rows_in)
            if len(rows) == 0:
                continue
            buffer.use()
            nearest_first = rows[np.argsort(view.far_end[rows], kind="stable")]
            by_mesh = nearest_first[np.argsort(table.mesh_of(nearest_first), kind="stable")]
            for number, run in table.runs(by_mesh):
                plain = buffer is target.target
                program = self._programs["plain"] if plain else self._painting(ribs_of(table.meshes[number]))
                view.batches[number].draw_levels(program, view.records[run], view.levels[run])

    def _prepare(self, camera: PinholeCamera, size: tuple[int, int], materials: MaterialTable) -> None:
        """Set what all draws share."""
        self._context.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._context.depth_func = ">"  # reversed depth: nearer is larger
        self._context.front_face = "cw"  # the window's first row is the image's top row, which mirrors the faces
        self._context.cull_face = "back"
        for program in self._programs.values():
            assign(program, intrinsics=window_intrinsics(camera), origin=image_origin(size))
        materials.values.use(0)
        materials.pictures.array.use(_PICTURES_UNIT)

    def _painting(self, ribs: Ribs | None) -> moderngl.Program:
        """Return the program for painted parts; one without a picture paints nothing."""
        if ribs is None:
            return self._programs["picture"]
        program = self._programs["ribs"]
        assign(program, rib_edges=ribs.edges, rib_shape=(ribs.pitch, ribs.low, ribs.high, float(ribs.side)))
        return program
