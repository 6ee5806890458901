"""Shadow maps of the most important spot lights, rendered once a scene into one depth atlas."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import moderngl
import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.render.light_selection import WIDE_TO
from warehouse_sim.render.raster.context import FullScreen, clear_to_zero, float_depth_texture, source
from warehouse_sim.render.raster.light.shadow_shapes import shadow_shape, thinned_sheets
from warehouse_sim.render.raster.meshes.mesh_batch import MeshBatch, MeshLibrary, choose_levels, only_level
from warehouse_sim.render.raster.meshes.parts import PartTable, placed_records
from warehouse_sim.render.raster.projection import projected_bounds
from warehouse_sim.schema import Light

MAX_SHADOWS = 8
"""Maps that a view looks up; of more, those that matter most to it. Point lights have none."""
ATLAS_PX = 4096
"""Edge of the atlas that holds all maps: at least two rows and two columns, and as many columns as rows or one more."""
BLOCK_TEXELS = 8
"""Edge of the blocks of which the nearest blocker is kept beside the maps."""
SHADOW_NEAR = 0.1
"""Nearest distance along its axis at which something shades a light (m)."""
_MARGIN_PX = 8  # texels that the filter reads around a point
_UNIT_CAMERA = PinholeCamera(1, 1, 1.0, 1.0, 0.0, 0.0)  # projects to tangents
_FLOOR = 1e-3  # what lies wholly at or below this height (m) can shade nothing


@dataclass(frozen=True, eq=False)
class ShadowTile:
    """Where one light's map lies in the atlas, and how directions map into it."""

    T_world_light: Transform
    """Camera-like frame at the light: z along its axis."""
    scale: tuple[float, float]
    """Atlas coordinate = ``scale * (x, y) / z + offset`` for a point in the light frame."""
    offset: tuple[float, float]
    low: tuple[float, float]
    """Least atlas coordinates at which the filter stays inside the tile."""
    high: tuple[float, float]
    """Greatest such coordinates."""
    texel_angle: float
    """Width of a texel at z = 1 m (m)."""


class ShadowAtlas:
    """Depth of the back faces of all casters, seen from each light.

    Back faces, because they lie away from every lit surface: no surface shades itself for want of resolution, and the
    offset that would otherwise be needed, and lifts shadows off their casters, can be small.
    """

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._program = context.program(
            vertex_shader=source("place.glsl", "shadow.vert"), fragment_shader=source("shadow.frag")
        )
        self._program["near"] = SHADOW_NEAR
        self.depth = float_depth_texture(context, (ATLAS_PX, ATLAS_PX))
        self.depth.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self.depth.compare_func = ""  # the shader compares: cheaper than a comparing sampler on a CPU
        self.depth.repeat_x = self.depth.repeat_y = False
        self._target = context.framebuffer([], self.depth)
        self._shapes = MeshLibrary(context, only_level)
        edge = ATLAS_PX // BLOCK_TEXELS
        self.blockers = context.texture((edge, edge), 1, dtype="f4")
        self.blockers.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self.blockers.repeat_x = self.blockers.repeat_y = False
        self._blocker_target = context.framebuffer([self.blockers])
        self._find_blockers = FullScreen(context, "blockers.frag", ATLAS_PX=float(ATLAS_PX), BLOCK_TEXELS=BLOCK_TEXELS)

    def draw(self, lights: Sequence[Light], table: PartTable, batches: Sequence[MeshBatch]) -> list[ShadowTile]:
        """Draw the maps of some spots; return where each of them lies."""
        self._target.use()
        clear_to_zero(None, "f")
        self._context.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._context.depth_func = ">"
        self._context.front_face = "cw"
        self._context.cull_face = "front"
        casters = table.casts & (table.tops() > _FLOOR)
        batches = self._with_shapes(table, casters, batches)
        columns = max(math.ceil(math.sqrt(len(lights))), 2)
        size = ATLAS_PX // columns, ATLAS_PX // max(math.ceil(len(lights) / columns), 2)
        corners = [(number % columns * size[0], number // columns * size[1]) for number in range(len(lights))]
        tiles = [
            self._draw_tile(light, corner, size, table, casters, batches)
            for light, corner in zip(lights, corners, strict=True)
        ]
        self._target.viewport = (0, 0, *self._target.size)
        self.depth.use(0)
        self._find_blockers.assign(shadow_atlas=0)
        self._find_blockers.draw(self._blocker_target)
        return tiles

    def _with_shapes(self, table: PartTable, casters: np.ndarray, batches: Sequence[MeshBatch]) -> Sequence[MeshBatch]:
        """Return ``batches`` with coarse ones for the meshes that have a shape of their own for shadows."""
        shapes: list[TriangleMesh | None] = []
        for mesh, rows, filled in zip(table.meshes, table.rows_of_mesh, table.filled, strict=True):
            shape = shadow_shape(mesh, filled) if casters[rows].any() else mesh
            shapes.append(None if shape is mesh else shape)
        own = [shape for shape in shapes if shape is not None]
        coarse = iter(self._shapes.require(own))
        return [batch if shape is None else next(coarse) for shape, batch in zip(shapes, batches, strict=True)]

    def _draw_tile(
        self,
        light: Light,
        corner: tuple[int, int],
        size: tuple[int, int],
        table: PartTable,
        casters: np.ndarray,
        batches: Sequence[MeshBatch],
    ) -> ShadowTile:
        T_world_light = light_frame(light)
        records = placed_records(table, T_world_light)
        reach = float(np.tan(min(light.cone_outer, WIDE_TO)))
        left, top, right, bottom = _window(table, records, casters, reach)
        (column, row), (width, height) = corner, size
        fx, fy = (width - 2 * _MARGIN_PX) / (right - left), (height - 2 * _MARGIN_PX) / (bottom - top)
        self._target.viewport = (column, row, width, height)
        cx, cy = _MARGIN_PX - left * fx, _MARGIN_PX - top * fy
        self._program["intrinsics"] = (fx, fy, cx, cy)
        self._program["window"] = size
        # The map as a camera: what it cannot show apart need not be rendered apart.
        as_camera = PinholeCamera(width, height, fx, fy, cx, cy)
        levels = choose_levels(table, [batch.errors for batch in batches], records, as_camera)
        sampled = thinned_sheets(table, records)
        for rows, batch in zip(table.rows_of_mesh, batches, strict=True):
            batch.draw_levels(self._program, sampled[rows][casters[rows]], levels[rows][casters[rows]])
        return ShadowTile(
            T_world_light=T_world_light,
            scale=(fx / ATLAS_PX, fy / ATLAS_PX),
            offset=((column + cx) / ATLAS_PX, (row + cy) / ATLAS_PX),
            low=((column + _MARGIN_PX) / ATLAS_PX, (row + _MARGIN_PX) / ATLAS_PX),
            high=((column + width - _MARGIN_PX) / ATLAS_PX, (row + height - _MARGIN_PX) / ATLAS_PX),
            texel_angle=max(1.0 / fx, 1.0 / fy),
        )


def light_frame(light: Light) -> Transform:
    """Return ``T_world_light``: origin at the light, z along its axis."""
    z = np.asarray(light.direction, float) / np.linalg.norm(light.direction)
    across = np.eye(3)[np.argmin(np.abs(z))]
    x = np.cross(across, z) / np.linalg.norm(np.cross(across, z))
    return make_transform(np.stack([x, np.cross(z, x), z], axis=1), np.asarray(light.position, float))


def _window(
    table: PartTable, records: np.ndarray, casters: np.ndarray, reach: float
) -> tuple[float, float, float, float]:
    """Return left, top, right, bottom at z = 1 m of the directions in which the cone meets a caster.

    Args:
        table: The scene.
        records: The table placed in the light frame.
        casters: Which rows cast shadows.
        reach: Tangent of the cone's half angle.
    """
    rotation = np.swapaxes(records["rotation"][casters], 1, 2)
    bounds = projected_bounds(
        _UNIT_CAMERA,
        rotation,
        records["translation"][casters],
        table.local_centre[casters],
        table.half_size[casters],
    )
    left, top, right, bottom = np.clip(bounds if bounds is not None else np.zeros(4), -reach, reach)
    # At least a sliver, where nothing stands in the cone.
    return left, top, max(right, left + SHADOW_NEAR), max(bottom, top + SHADOW_NEAR)
