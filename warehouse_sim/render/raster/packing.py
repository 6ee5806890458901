"""Packing of rectangles into pages of a fixed size."""

from collections.abc import Iterable
from dataclasses import dataclass, replace


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
