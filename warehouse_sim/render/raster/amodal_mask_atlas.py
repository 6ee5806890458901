"""Unoccluded amodal masks of many objects, drawn side by side in one target on the image's own pixel grid."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import moderngl
import numpy as np
from jaxtyping import Int

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render.raster.context import assign, source
from warehouse_sim.render.raster.meshes.mesh_batch import MeshBatch, choose_levels
from warehouse_sim.render.raster.meshes.parts import PartTable
from warehouse_sim.render.raster.projection import (
    NEAR,
    WINDOW_PX,
    box_bounds,
    image_origin,
    window_intrinsics,
    window_viewport,
)
from warehouse_sim.render.renderer import NOTHING_COVERED, AmodalMask


@dataclass(frozen=True)
class Cell:
    """A rectangle of the canvas around the image, and where it lies in a page."""

    left: int
    """Image column that the first column shows; may be negative."""
    top: int
    """Image row that the first row shows; may be negative."""
    width: int
    height: int
    column: int = 0
    """First column in the page."""
    row: int = 0
    """First row in the page."""


def pack(cells: Iterable[tuple[int, Cell]], page_size: tuple[int, int]) -> list[list[tuple[int, Cell]]]:
    """Place numbered cells on shelves, the highest first, and open a new page when one is full.

    Args:
        cells: Pairs of a number, which is kept, and a cell no larger than a page.
        page_size: Width and height of a page.
    """
    width, height = page_size
    pages: list[list[tuple[int, Cell]]] = []
    column = row = shelf = 0
    for number, cell in sorted(cells, key=lambda item: (-item[1].height, item[0])):
        if column + cell.width > width:
            column, row, shelf = 0, row + shelf, 0
        if not pages or row + cell.height > height:
            pages.append([])
            column = row = shelf = 0
        pages[-1].append((number, replace(cell, column=column, row=row)))
        column, shelf = column + cell.width, max(shelf, cell.height)
    return pages


class AmodalMaskAtlas:
    """Draws amodal masks: white where an object is, black elsewhere, one draw call a mesh for all objects."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._program = context.program(
            vertex_shader=source("place.glsl", "amodal_mask.vert"), fragment_shader=source("amodal_mask.frag")
        )
        assign(self._program, near=NEAR, window=(WINDOW_PX, WINDOW_PX), cells=0)
        self._target: moderngl.Framebuffer | None = None

    def draw(
        self,
        camera: PinholeCamera,
        table: PartTable,
        records: np.ndarray,
        batches: Sequence[MeshBatch],
        owner: Int[np.ndarray, " n"],
        count: int,
    ) -> list[AmodalMask]:
        """Return the amodal masks of ``count`` objects.

        Args:
            camera: Intrinsics of the image whose pixel grid is used.
            table: The solid parts of these objects, each object as often as it is requested.
            records: The table placed in the camera frame.
            batches: One for each mesh of the table.
            owner: Which of the objects each row belongs to.
            count: How many objects there are.
        """
        target = self._target_for(camera)
        levels = choose_levels(table, [batch.errors for batch in batches], records, camera)
        result = [NOTHING_COVERED] * count
        cells = canvas_cells(camera, table, records, owner, count)
        for page in pack(cells, (page_width(cells, target.size[0]), target.size[1])):
            image = self._draw_page(target, camera, table, records, batches, owner, levels, page)
            for number, cell in page:
                band = image[cell.row : cell.row + cell.height, cell.column : cell.column + cell.width]
                result[number] = AmodalMask.of(band > 0, cell.left, cell.top)
        return result

    def _draw_page(
        self,
        target: moderngl.Framebuffer,
        camera: PinholeCamera,
        table: PartTable,
        records: np.ndarray,
        batches: Sequence[MeshBatch],
        owner: Int[np.ndarray, " n"],
        levels: Int[np.ndarray, " n"],
        page: list[tuple[int, Cell]],
    ) -> np.ndarray:
        width = max(cell.column + cell.width for _, cell in page)
        height = max(cell.row + cell.height for _, cell in page)
        target.use()
        target.clear(viewport=(0, 0, width, height))
        self._context.enable_only(moderngl.CULL_FACE)
        self._context.front_face, self._context.cull_face = "cw", "back"
        target.viewport = window_viewport(target.size)
        rectangles = self._upload_cells([cell for _, cell in page])
        rectangles.use(0)
        place = np.full(owner.max(initial=0) + 1, -1)
        place[[number for number, _ in page]] = np.arange(len(page))
        records["identity"][:, 0] = place[owner]  # the cell in place of the instance
        assign(self._program, intrinsics=window_intrinsics(camera), origin=image_origin(target.size))
        cut = np.array([_touches_border(cell, camera) for _, cell in page])
        whole = np.flatnonzero((place[owner] >= 0) & ~cut[place[owner]])
        self._draw_rows(table, records, batches, levels, whole)
        for number, cell in (page[k] for k in np.flatnonzero(cut).tolist()):
            # What leaves the canvas must not run over into the next cell.
            target.scissor = (cell.column, cell.row, cell.width, cell.height)
            self._draw_rows(table, records, batches, levels, np.flatnonzero(owner == number))
        target.scissor = None  # type: ignore[assignment]  # moderngl's stub knows rectangles only
        image = np.empty((height, width), np.uint8)
        target.read_into(image, viewport=(0, 0, width, height), components=1, alignment=1)
        return image

    def _draw_rows(
        self,
        table: PartTable,
        records: np.ndarray,
        batches: Sequence[MeshBatch],
        levels: Int[np.ndarray, " n"],
        rows: Int[np.ndarray, " k"],
    ) -> None:
        """Draw the parts in ``rows``, which rise."""
        ends = np.searchsorted(rows, [group.stop for group in table.rows_of_mesh])
        for mesh in np.flatnonzero(np.diff(ends, prepend=0)).tolist():
            part = rows[ends[mesh - 1] if mesh else 0 : ends[mesh]]
            batches[mesh].draw_levels(self._program, records[part], levels[part])

    def _upload_cells(self, cells: list[Cell]) -> moderngl.Texture:
        shifts = np.array([(cell.column - cell.left, cell.row - cell.top) for cell in cells], np.int32)
        texture = self._context.texture((1, len(cells)), 2, shifts.tobytes(), dtype="i4")
        texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        return texture

    def _target_for(self, camera: PinholeCamera) -> moderngl.Framebuffer:
        width, height = (max(1 << (3 * edge - 1).bit_length(), 1024) for edge in (camera.width, camera.height))
        size = (width, height)
        if self._target is None or self._target.size != size:
            self._target = self._context.framebuffer([self._context.texture(size, 1, alignment=1)])
            self._target.use()  # so that none is bound when it is freed
        return self._target


def canvas_cells(
    camera: PinholeCamera, table: PartTable, records: np.ndarray, owner: Int[np.ndarray, " n"], count: int
) -> list[tuple[int, Cell]]:
    """Return the rectangles of the 3W x 3H canvas that hold the objects that can be seen there, with their numbers."""
    rotation = np.swapaxes(records["rotation"], 1, 2)
    bounds = box_bounds(camera, rotation, records["translation"], table.local_centre, table.half_size)
    low, high = np.full((count, 2), np.inf), np.full((count, 2), -np.inf)
    np.minimum.at(low, owner, bounds[0])
    np.maximum.at(high, owner, bounds[1])
    size = np.array([camera.width, camera.height])
    seen = (low < 2 * size).all(axis=1) & (high > -size - 1).all(axis=1)
    first = np.maximum(np.floor(low[seen]) - 1, -size).astype(int)
    last = np.minimum(np.ceil(high[seen]) + 1, 2 * size - 1).astype(int)
    corners = zip(np.flatnonzero(seen).tolist(), first.tolist(), (last - first + 1).tolist(), strict=True)
    return [(number, Cell(left, top, width, height)) for number, (left, top), (width, height) in corners]


def _touches_border(cell: Cell, camera: PinholeCamera) -> bool:
    """Return whether the canvas may have cut off what the cell holds."""
    right, bottom = cell.left + cell.width, cell.top + cell.height
    inside = cell.left > -camera.width and cell.top > -camera.height
    return not (inside and right < 2 * camera.width and bottom < 2 * camera.height)


def page_width(cells: Sequence[tuple[int, Cell]], limit: int) -> int:
    """Return a width (px) that makes the page about square: what is not covered is cleared and read in vain."""
    area = sum(cell.width * cell.height for _, cell in cells)
    return min(limit, max([int(1.1 * area**0.5) + 1, *(cell.width for _, cell in cells)]))
