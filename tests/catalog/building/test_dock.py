import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.building import DOOR_SIZE, OPEN_DOOR_SIZE, OPENING_HEIGHT, OPENING_WIDTH, TRAILER_SIZE
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.geometry.separation import BoxStack


def box(size: tuple[float, float, float], at: tuple[float, float, float]) -> OrientedBox:
    return OrientedBox(make_transform(translation=np.array(at)), np.array(size))


def test_a_closed_door_covers_the_opening() -> None:
    leaf = max(catalog_object("dock_door_closed").collision, key=lambda item: item.size[0] * item.size[2])
    assert leaf.size[0] == OPENING_WIDTH
    assert leaf.corners()[:, 2].min() == pytest.approx(-DOOR_SIZE[2] / 2)
    assert leaf.size[2] == OPENING_HEIGHT


def test_an_open_door_leaves_the_opening_and_the_way_to_it_free() -> None:
    door = BoxStack.of(catalog_object("dock_door_open").collision)
    way = box((OPENING_WIDTH - 1e-6, 6.0, OPENING_HEIGHT), (0.0, 0.0, -OPEN_DOOR_SIZE[2] / 2 + OPENING_HEIGHT / 2))
    assert door.clear_of(way, 0.05)


def test_a_trailer_is_open_at_the_dock_and_wide_enough_for_pallets() -> None:
    walls = BoxStack.of(catalog_object("trailer").collision)
    room = box((2.4, 13.0, 2.4), (0.0, -1.0, 0.0))
    assert walls.clear_of(room, 0.0)
    assert TRAILER_SIZE[0] <= 2.55 < OPENING_WIDTH


def test_windows_are_in_one_section() -> None:
    door = catalog_object("dock_door_closed")
    panes = next(part for part in door.parts if part.material == "window_pane").placed().vertices
    section = OPENING_HEIGHT / 5
    number = (panes[:, 2] + DOOR_SIZE[2] / 2) / section
    assert 2.0 < number.min() < number.max() < 3.0
