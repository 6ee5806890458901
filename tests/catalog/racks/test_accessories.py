import numpy as np
import pytest

from tests.catalog.covering import bare_distances, shipped
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.racks.accessories import DECK_WIDTH


@pytest.mark.parametrize(
    ("name", "class_name", "size"),
    [
        ("mesh_deck", "rack", (0.88, 1.04, 0.041)),
        ("pallet_support_bar", "rack", (0.04, 1.04, 0.041)),
        ("upright_guard", "guard", (0.17, 0.14, 0.4)),
        ("rack_end_guard", "guard", (0.12, 1.2, 0.4)),
        ("load_notice", "sign", (0.6, 0.004, 0.4)),
    ],
)
def test_outer_sizes_and_classes(name: str, class_name: str, size: tuple[float, float, float]) -> None:
    model = catalog_object(name)
    assert model.class_name == class_name
    np.testing.assert_allclose(model.size, size)


def test_collision_boxes_cover_the_mesh_to_9_mm() -> None:
    for name in shipped("racks"):
        assert bare_distances(catalog_object(name)).max() < 0.009, name


def test_a_deck_is_a_mesh_with_open_cells() -> None:
    deck = catalog_object("mesh_deck").mesh()
    wires = np.unique(np.round(deck.vertices[deck.vertices[:, 2] > 0.0204, 0], 6))
    # Two sides of each wire; 18 clear cells of 44-45 mm between 19 wires.
    assert len(wires) == 2 * 19
    np.testing.assert_allclose(np.diff(wires)[1::2], (DECK_WIDTH - 0.005) / 18 - 0.005, atol=1e-5)
