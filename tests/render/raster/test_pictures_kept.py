import pytest

from warehouse_sim.render.raster import surfaces
from warehouse_sim.render.raster.context import open_context

pytestmark = pytest.mark.gl


def test_a_picture_is_drawn_once_however_often_new_ones_come(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[str] = []
    texels = surfaces._texels
    monkeypatch.setattr(surfaces, "_texels", lambda name: drawn.append(name) or texels(name))
    with open_context() as context:
        library = surfaces.PictureLibrary(context)
        library.require(["shipping_label:0"])
        layers = library.require(["shipping_label:0", "shipping_label:1"])
        assert layers == {"shipping_label:0": 0, "shipping_label:1": 1}
    assert drawn == ["shipping_label:0", "shipping_label:1"]
