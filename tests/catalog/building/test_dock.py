import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.building.dock import DOOR_SIZE, OPEN_DOOR_SIZE, SEAL_SIZE, TRAILER_SIZE
from warehouse_sim.catalog.building.shell import OPENING_HEIGHT, OPENING_WIDTH
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.geometry.separation import BoxStack


def box(size: tuple[float, float, float], at: tuple[float, float, float]) -> OrientedBox:
    return OrientedBox(make_transform(translation=np.array(at)), np.array(size))


def test_a_closed_door_covers_the_opening() -> None:
    leaf = max(catalog_object("dock_door_closed").collision, key=lambda item: item.size[0] * item.size[2])
    assert leaf.size[0] == pytest.approx(OPENING_WIDTH + 0.05)
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


def test_a_seal_overlaps_the_trailer_and_the_wall_on_three_sides() -> None:
    pads = BoxStack.of(catalog_object("dock_seal").collision)
    low, high = pads.extents()
    floor = -SEAL_SIZE[2] / 2
    assert pads.clear_of(box((2.39, 0.2, 2.59), (0.0, 0.0, floor + 1.295)), 0.0)  # a way as wide as the trailer's room
    half, roof = TRAILER_SIZE[0] / 2, TRAILER_SIZE[2] - 0.03
    for sign in (-1.0, 1.0):
        side = sign * np.stack([low, high])[:, :, 0]
        assert np.any((side.min(axis=0) < half - 0.05) & (side.max(axis=0) > OPENING_WIDTH / 2 + 0.1))
    assert np.any((low[:, 2] - floor < roof - 0.05) & (high[:, 2] - floor > OPENING_HEIGHT + 0.1))


def test_windows_are_in_one_section() -> None:
    door = catalog_object("dock_door_closed")
    panes = next(part for part in door.parts if part.material == "window_pane").placed().vertices
    section = OPENING_HEIGHT / 5
    number = (panes[:, 2] + DOOR_SIZE[2] / 2) / section
    assert 2.0 < number.min() < number.max() < 3.0
