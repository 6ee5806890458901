"""Cells of amodal masks on pages."""

import numpy as np

from warehouse_sim.render.raster.amodal_mask_atlas import Cell, pack


def test_cells_keep_their_size_and_never_overlap_or_leave_the_page() -> None:
    rng = np.random.default_rng(0)
    cells = [(k, Cell(-k, k, int(rng.integers(1, 90)), int(rng.integers(1, 60)))) for k in range(200)]
    pages = pack(cells, (200, 100))
    assert len(pages) > 1
    for page in pages:
        taken = np.zeros((100, 200), int)
        for number, cell in page:
            given = cells[number][1]
            assert (cell.left, cell.top) == (given.left, given.top)
            assert (cell.width, cell.height) == (given.width, given.height)
            assert cell.column + cell.width <= 200
            assert cell.row + cell.height <= 100
            taken[cell.row : cell.row + cell.height, cell.column : cell.column + cell.width] += 1
        assert taken.max() == 1
    assert sorted(number for page in pages for number, _ in page) == list(range(200))
