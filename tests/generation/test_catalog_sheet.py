from pathlib import Path

import cv2
import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.errors import UnknownNameError
from warehouse_sim.generation.catalog_sheet import CAPTION, HEIGHT, WIDTH, render_catalog_sheet, render_thumbnail
from warehouse_sim.render import Renderer

pytestmark = pytest.mark.gl
NAMES = ("epal1", "rack_beam_2700", "highbay_luminaire")


def test_the_sheet_holds_one_cell_an_object_in_the_order_requested_for(tmp_path: Path) -> None:
    names = ["epal1", "carton_600x400x300", "rack_beam_2700", "highbay_luminaire"]
    render_catalog_sheet(tmp_path / "new" / "sheet.png", names, columns=3)
    sheet = cv2.imread(str(tmp_path / "new" / "sheet.png"))
    assert sheet.shape == (2 * (HEIGHT + CAPTION), 3 * WIDTH, 3)
    done: list[tuple[int, int]] = []
    render_catalog_sheet(
        tmp_path / "other.png", [names[3], names[1]], columns=3, progress=lambda *counts: done.append(counts)
    )
    assert done == [(1, 2), (2, 2)]
    other = cv2.imread(str(tmp_path / "other.png"))
    assert other.shape == (HEIGHT + CAPTION, 2 * WIDTH, 3)
    assert np.array_equal(other[:, WIDTH:], sheet[: HEIGHT + CAPTION, WIDTH : 2 * WIDTH])
    assert np.array_equal(other[:, :WIDTH], sheet[HEIGHT + CAPTION :, :WIDTH])
    assert (sheet[HEIGHT + CAPTION :, WIDTH:] == 24).all()  # what the last row lacks


@pytest.mark.parametrize(
    "name", ["epal1", "rack_beam_2700", pytest.param("floor_slab", marks=pytest.mark.slow), "highbay_luminaire"]
)
def test_an_object_fills_its_thumbnail_whatever_its_size(
    renderer: Renderer, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    seen, original = {}, renderer.render

    def remember(*arguments: object, **keywords: object) -> object:
        seen["buffers"] = original(*arguments, **keywords)  # type: ignore[arg-type]
        return seen["buffers"]

    monkeypatch.setattr(renderer, "render", remember)
    thumbnail = render_thumbnail(renderer, catalog_object(name))
    ids = seen["buffers"].instance_mask
    rows, columns = np.nonzero(ids == 2)
    spans = (columns.min() / ids.shape[1], columns.max() / ids.shape[1], rows.min() / ids.shape[0])
    spans += (rows.max() / ids.shape[0],)
    assert min(spans[0], spans[2]) == pytest.approx(0.05, abs=0.02)
    assert max(spans[1], spans[3]) == pytest.approx(0.95, abs=0.02)
    assert (ids > 0).mean() > 0.99  # the floor reaches beyond the image
    assert thumbnail.shape == (HEIGHT, WIDTH, 3)
    assert thumbnail.std() > 4.0


def test_an_unknown_object_is_named(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match="palet"):
        render_catalog_sheet(tmp_path / "sheet.png", ["palet"])
    assert not (tmp_path / "sheet.png").exists()
