"""Unoccluded silhouettes of many objects, drawn side by side in one target on the image's own pixel grid."""

from collections.abc import Sequence

import moderngl
import numpy as np

from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render.raster.mesh_batch import MeshBatch
from warehouse_sim.render.raster.packing import Cell, pack
from warehouse_sim.render.raster.parts import PartTable
from warehouse_sim.render.raster.programs import source
from warehouse_sim.render.raster.projection import (
    NEAR,
    WINDOW_PX,
    image_origin,
    projected_bounds,
    window_intrinsics,
    window_viewport,
)
from warehouse_sim.render.renderer import Silhouette

_EMPTY = Silhouette((0, 0), np.zeros((0, 0), bool))


class SilhouetteAtlas:
    """Draws silhouettes: white where an object is, black elsewhere, one draw call a mesh for all objects."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._program = context.program(
            vertex_shader=source("place.glsl", "silhouette.vert"), fragment_shader=source("silhouette.frag")
        )
        self._program["near"] = NEAR
        self._program["window"] = (WINDOW_PX, WINDOW_PX)
        self._program["cells"] = 0
        self._texture: moderngl.Texture | None = None
        self._target: moderngl.Framebuffer | None = None

    def draw(
        self,
        camera: PinholeCamera,
        table: PartTable,
        records: np.ndarray,
        batches: Sequence[MeshBatch],
        instance_ids: Sequence[int],
    ) -> list[Silhouette]:
        """Return the silhouettes of the objects with ``instance_ids``.

        Args:
            camera: Intrinsics of the image whose pixel grid is used.
            table: The scene.
            records: The table placed in the camera frame.
            batches: One for each mesh of the table.
            instance_ids: Which objects; in the order of the result.
        """
        target = self._target_for(camera)
        wanted = [canvas_cell(camera, table, records, instance_id) for instance_id in instance_ids]
        result = [_EMPTY] * len(instance_ids)
        for page in pack([(number, cell) for number, cell in enumerate(wanted) if cell is not None], target.size):
            image = self._draw_page(target, camera, table, records, batches, instance_ids, page)
            for number, cell in page:
                result[number] = _tight(image[cell.row : cell.row + cell.height], cell)
        return result

    def release(self) -> None:
        """Free the device memory."""
        self._program.release()
        if self._target is not None and self._texture is not None:
            self._target.release()
            self._texture.release()

    def _draw_page(
        self,
        target: moderngl.Framebuffer,
        camera: PinholeCamera,
        table: PartTable,
        records: np.ndarray,
        batches: Sequence[MeshBatch],
        instance_ids: Sequence[int],
        page: list[tuple[int, Cell]],
    ) -> np.ndarray:
        width, height = target.size[0], max(cell.row + cell.height for _, cell in page)
        target.use()
        target.clear(viewport=(0, 0, width, height))
        self._context.enable_only(moderngl.CULL_FACE)
        self._context.front_face, self._context.cull_face = "cw", "back"
        self._program["intrinsics"] = window_intrinsics(camera)
        self._program["origin"] = image_origin(target.size)
        target.viewport = window_viewport(target.size)
        rectangles = self._upload_cells([cell for _, cell in page])
        rectangles.use(0)
        rows = np.concatenate([table.rows_of_instance[instance_ids[number]] for number, _ in page])
        counts = [len(table.rows_of_instance[instance_ids[number]]) for number, _ in page]
        chosen = records[rows]
        chosen["identity"][:, 0] = np.repeat(np.arange(len(page)), counts)  # the cell in place of the instance
        for mesh_rows, batch in zip(table.rows_of_mesh, batches, strict=True):
            batch.draw(self._program, chosen[(rows >= mesh_rows.start) & (rows < mesh_rows.stop)])
        image = np.empty((height, width), np.uint8)
        target.read_into(image, viewport=(0, 0, width, height), components=1, alignment=1)
        rectangles.release()
        return image

    def _upload_cells(self, cells: list[Cell]) -> moderngl.Texture:
        values = np.zeros((len(cells), 2, 4), np.int32)
        for value, cell in zip(values, cells, strict=True):
            value[0, :2] = cell.column - cell.left, cell.row - cell.top
            value[1] = cell.column, cell.row, cell.column + cell.width, cell.row + cell.height
        texture = self._context.texture((2, len(cells)), 4, values.tobytes(), dtype="i4")
        texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        return texture

    def _target_for(self, camera: PinholeCamera) -> moderngl.Framebuffer:
        width, height = (max(1 << (3 * edge - 1).bit_length(), 1024) for edge in (camera.width, camera.height))
        size = (width, height)
        if self._target is None or self._target.size != size:
            before = self._target, self._texture
            self._texture = self._context.texture(size, 1, alignment=1)
            self._target = self._context.framebuffer([self._texture])
            self._target.use()  # so that none is bound when it is released
            for item in before:
                if item is not None:
                    item.release()
        return self._target


def canvas_cell(camera: PinholeCamera, table: PartTable, records: np.ndarray, instance_id: int) -> Cell | None:
    """Return the rectangle of the 3W x 3H canvas that holds the object, or None when it cannot be seen there."""
    rows = table.rows_of_instance[instance_id]
    bounds = projected_bounds(
        camera,
        np.swapaxes(records["rotation"][rows], 1, 2),
        records["translation"][rows],
        table.local_centre[rows],
        table.half_size[rows],
    )
    if bounds is None:
        return None
    left, top, right, bottom = bounds
    left, right = max(int(np.floor(left)) - 1, -camera.width), min(int(np.ceil(right)) + 1, 2 * camera.width - 1)
    top, bottom = max(int(np.floor(top)) - 1, -camera.height), min(int(np.ceil(bottom)) + 1, 2 * camera.height - 1)
    if left > right or top > bottom:
        return None
    return Cell(left, top, right - left + 1, bottom - top + 1)


def _tight(band: np.ndarray, cell: Cell) -> Silhouette:
    mask = band[:, cell.column : cell.column + cell.width] > 0
    box = mask_box_xyxy(mask)
    if box is None:
        return _EMPTY
    left, top, right, bottom = box
    return Silhouette((cell.left + left, cell.top + top), mask[top : bottom + 1, left : right + 1].copy())
