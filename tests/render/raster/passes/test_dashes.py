"""What is drawn of a line thinner than a pixel is joined to one line, and nothing else is."""

import numpy as np
import pytest

from tests.render.raster.passes.test_antialias import boards, rendered_coverage
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render import Renderer
from warehouse_sim.render.raster.passes.dashes import Strips, joined

SIZE = 60, 40


def line(slope: float, width: float, start: float = 8.6) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the pixels whose centre a line lies on, and its width and offset there; it runs along the rows."""
    column = np.arange(SIZE[0])
    middle = start + slope * column
    row = np.rint(middle).astype(int)
    offset = (middle - row).astype(np.float32)
    seen = np.abs(offset) < width / 2
    return (row * SIZE[0] + column)[seen], np.full(seen.sum(), width, np.float32), offset[seen]


def filled(*lines: tuple[np.ndarray, np.ndarray, np.ndarray], nearer: int | None = None) -> np.ndarray:
    """Return the image of what pixels in gaps hold of lines."""
    pixels, width, offset = (np.concatenate(parts) for parts in zip(*lines, strict=True))
    order = np.argsort(pixels)
    strips = Strips(pixels[order], width[order], offset[order], SIZE[0])
    count = SIZE[0] * SIZE[1]
    nearness = np.full(count, 0.1, np.float32)
    if nearer is not None:
        nearness.reshape(SIZE[::-1])[:, nearer] = 0.2
    colors = np.full(count, 0x404040, np.uint32)
    found = joined(strips, SIZE, nearness, colors, np.empty(count, np.int32))
    return np.bincount(found.taking, found.fraction, count).reshape(SIZE[::-1])


@pytest.mark.parametrize("slope", [0.05, -0.05, 0.12, 0.3])
def test_gaps_hold_the_width_of_the_line_and_dashes_nothing_more(slope: float) -> None:
    dashes = line(slope, 0.6)
    held = filled(dashes).sum(axis=0)
    seen = np.isin(np.arange(SIZE[0]), dashes[0] % SIZE[0])
    inner = ~seen & (np.cumsum(seen) > 0) & (np.cumsum(seen[::-1])[::-1] > 0)
    assert inner.any()
    assert held[inner] == pytest.approx(np.full(inner.sum(), 0.6), abs=0.02)
    assert (held[seen] == 0.0).all()


def test_two_lines_are_not_joined_to_each_other() -> None:
    left, right = (line(0.05, 0.6, start) for start in (4.6, 5.4))
    first = [part[left[0] % SIZE[0] < 12] for part in left]
    second = [part[right[0] % SIZE[0] > 30] for part in right]
    alone = filled(tuple(first)) + filled(tuple(second))
    np.testing.assert_array_equal(filled(tuple(first), tuple(second)), alone)


def test_what_stands_before_the_line_holds_nothing_of_it() -> None:
    gap = int(np.flatnonzero(filled(line(0.05, 0.6)).sum(axis=0))[3])
    assert filled(line(0.05, 0.6), nearer=gap)[:, gap].sum() == 0.0


@pytest.mark.gl
@pytest.mark.parametrize("angle", [0.02, 0.3, 0.8, 1.52])
def test_a_rendered_line_of_two_thirds_of_a_pixel_has_no_gaps(renderer: Renderer, angle: float) -> None:
    renderer.load(boards(angle, 0.0139, 15.0))
    camera = PinholeCamera.from_focal(612, 370, 721.5377)
    light, ids = rendered_coverage(renderer, camera)
    across = 0 if angle < 0.79 else 1
    middle = slice(290, 322) if across == 0 else slice(169, 201)
    columns = light.sum(axis=across)[middle]
    assert columns.min() > 0.6 * columns.max()
    assert (ids > 0).any()
