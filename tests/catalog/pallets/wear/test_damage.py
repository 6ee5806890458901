import numpy as np
import pytest

from tests.catalog.pallets.wear.used import KINDS, ruined, wood
from warehouse_sim.catalog import catalog_names, catalog_object
from warehouse_sim.catalog.pallets.wear.damage import FARTHEST, WIDEST_GAP, members_of
from warehouse_sim.catalog.pallets.wear.damaged import WearConfig


def test_no_carton_of_the_catalog_is_narrower_than_the_widest_gap() -> None:
    cartons = [model for model in map(catalog_object, catalog_names()) if model.class_name == "carton"]
    assert min(model.size[:2].min() for model in cartons) >= WIDEST_GAP


@pytest.mark.parametrize("name", ["epal1", "epal2", "epal3", "epal6"])
def test_no_carton_falls_through_where_a_board_is_missing(name: str) -> None:
    built = sum(member.role == "deck" for member in members_of(catalog_object(name)))
    wear = WearConfig(missing=1.0, displaced=1.0)
    for seed in range(8):
        model = ruined(name, seed, wear)
        boards = [part for part in wood(model) if part.scale[2] < 0.03]
        deck = [part for part in boards if part.T_object_part[2, 3] > model.size[2] / 2 - part.scale[2]]
        assert built / 2 <= len(deck) < built
        across = int(np.argmin(deck[0].scale[:2]))
        vertices = [part.placed().vertices[:, across] for part in deck]
        spans = np.array(sorted((v.min(), v.max()) for v in vertices))
        assert (spans[1:, 0] - spans[:-1, 1]).max() <= WIDEST_GAP
        assert (spans[1:, 0] - spans[:-1, 1]).min() > 0.0


def test_only_boards_with_near_neighbours_go_missing() -> None:
    wear = WearConfig(missing=1.0, stamps=0.0)
    count = {name: len(wood(catalog_object(name))) - len(wood(ruined(name, 3, wear))) for name in KINDS}
    assert (count["gma_48x40"], count["blue_block_1200x1000"]) == (0, 0)
    assert count["epal1"] == 2  # the two narrow ones


def test_broken_boards_are_shorter_by_what_they_may_lose_and_end_in_splinters() -> None:
    new, old = catalog_object("epal1"), ruined("epal1", 2, WearConfig(broken=1.0, stamps=0.0))
    lengths = [float(part.scale[0]) for part in wood(old) if part.scale[0] > 0.8]
    assert len(lengths) == 8
    assert all(0.95 - 1e-9 <= length <= 1.18 + 1e-9 for length in lengths)
    assert len(old.parts) > len(new.parts) + 8 * 5
    assert {round(float(part.scale[0]), 9) for part in wood(new) if part.scale[0] > 0.8} == {1.2}


def test_blocks_turn_and_their_corners_move_by_at_most_10_mm() -> None:
    new, old = wood(catalog_object("epal1")), wood(ruined("epal1", 5, WearConfig(twisted=1.0)))
    turned = 0
    for before, after in zip(new, old, strict=True):
        moved = np.linalg.norm(before.placed().vertices - after.placed().vertices, axis=1).max()
        is_block = before.scale[2] > 0.05
        turned += is_block
        corner = float(np.hypot(*before.scale[:2])) / max(before.scale[:2])
        assert (0.002 < moved <= FARTHEST * corner * 1.01) if is_block else moved == 0.0
        outwards = np.abs(after.placed().vertices).max(axis=0) - np.abs(before.placed().vertices).max(axis=0)
        assert outwards.max() <= FARTHEST
    assert turned == 9


def test_displaced_boards_move_by_at_most_10_mm_sideways_and_stay_apart() -> None:
    new, old = wood(catalog_object("epal1")), wood(ruined("epal1", 4, WearConfig(displaced=1.0)))
    moves = [np.abs(a.placed().vertices - b.placed().vertices).max(axis=0) for a, b in zip(new, old, strict=True)]
    boards = [move for move, part in zip(moves, new, strict=True) if part.scale[0] > 1.0]
    assert len(boards) == 8
    assert all(0.0 < move[1] <= FARTHEST + 1e-6 and move[0] <= FARTHEST and move[2] == 0.0 for move in boards)
    assert sum(move.max() > 0 for move in moves) == 8
