from collections import Counter
from dataclasses import fields, replace

import numpy as np
import pytest

from tests.catalog.pallets.touching import hits, is_closed, prism_of
from tests.catalog.pallets.wear.used import KINDS, ruined, wood
from warehouse_sim.catalog import catalog_names, catalog_object
from warehouse_sim.catalog.materials import materials
from warehouse_sim.catalog.pallets import PALLETS
from warehouse_sim.catalog.pallets.wear.damage import FARTHEST, WIDEST_GAP, in_order, members_of, parallel
from warehouse_sim.catalog.pallets.wear.damaged import WearConfig, damaged
from warehouse_sim.schema.things import is_damaged

ALL = WearConfig(**dict.fromkeys((item.name for item in fields(WearConfig)), 1.0))


@pytest.mark.parametrize("name", PALLETS)
def test_the_meaning_stays(name: str) -> None:
    new, old = catalog_object(name), ruined(name, 1, ALL)
    assert old.name.startswith(f"{name}~")
    for field in ("class_name", "obj_id", "mass", "size", "pockets", "symmetry", "collision"):
        assert getattr(old, field) is getattr(new, field)


@pytest.mark.parametrize("name", PALLETS)
def test_a_pallet_is_called_damaged_only_where_its_surface_is_another(name: str) -> None:
    new, old = catalog_object(name).mesh(), ruined(name, 1, ALL)
    same = np.array_equal(new.faces, old.mesh().faces) and np.allclose(new.vertices, old.mesh().vertices)
    assert is_damaged(old.name) != same
    assert is_damaged(name) is False


@pytest.mark.parametrize("name", KINDS)
def test_pockets_shrunk_by_15_mm_stay_free(name: str) -> None:
    for seed in range(8):
        model = ruined(name, seed, ALL)
        for pocket in model.pockets:
            assert not hits(model, *prism_of(pocket, (0.0, -0.030, -0.030)))


def test_wear_does_reach_into_the_pockets_a_little() -> None:
    intruding = [
        hits(model, *prism_of(pocket, (0.0, -0.002, -0.002)))
        for model in (ruined("epal1", seed, ALL) for seed in range(4))
        for pocket in model.pockets
    ]
    assert any(intruding)


@pytest.mark.parametrize("name", KINDS)
def test_nothing_stands_out_by_more_than_a_twisted_block_may(name: str) -> None:
    for seed in range(8):
        vertices = ruined(name, seed, ALL).mesh().vertices
        half = catalog_object(name).size / 2
        assert np.all(np.abs(vertices[:, :2]) <= half[:2] + FARTHEST + 1e-3)
        assert np.all(np.abs(vertices[:, 2]) <= half[2] + 5e-4)


@pytest.mark.parametrize("name", PALLETS)
def test_every_part_is_closed_and_its_material_exists(name: str) -> None:
    for part in ruined(name, 6, ALL).parts:
        assert part.material in materials()
        assert is_closed(part.mesh)


def test_meshes_are_shared_between_damaged_pallets() -> None:
    pallets = [ruined("epal1", seed, WearConfig(age=0.5, stains=1.0)) for seed in range(20)]
    assert len({part.mesh for model in pallets for part in model.parts}) < 25


def test_the_same_stream_wears_alike_and_another_does_not() -> None:
    one, two, other = ruined("epal3", 1, ALL), ruined("epal3", 1, ALL), ruined("epal3", 2, ALL)
    assert one.name == two.name != other.name
    np.testing.assert_array_equal(one.mesh().vertices, two.mesh().vertices)
    assert one.mesh().vertices.shape != other.mesh().vertices.shape


def test_a_share_out_of_range_is_rejected() -> None:
    with pytest.raises(ValueError, match=r"broken must be 0-1, found 1\.5"):
        WearConfig(broken=1.5)


@pytest.mark.parametrize("name", ["epal1", "blue_block_1200x1000", "plastic_runners", "gma_48x40"])
def test_what_use_does_to_a_pallet_does_not_depend_on_what_it_is_called(name: str) -> None:
    model = catalog_object(name)
    wear = WearConfig(age=0.0, missing=0.6, broken=0.5, displaced=0.5, twisted=0.5, stamps=1.0)
    one = damaged(model, wear, np.random.default_rng(3))
    other = damaged(replace(model, name="plastic_of_my_own"), wear, np.random.default_rng(3))
    assert [part.material for part in one.parts] == [part.material for part in other.parts]
    for mine, theirs in zip(one.parts, other.parts, strict=True):
        np.testing.assert_array_equal(mine.T_object_part, theirs.T_object_part)


def test_pieces_without_a_role_stay_where_they_are() -> None:
    model = catalog_object("epal1")
    plain = replace(model, make="", parts=tuple(replace(part, role="") for part in model.parts))
    used = damaged(plain, WearConfig(missing=1.0, broken=1.0, displaced=1.0, twisted=1.0), np.random.default_rng(0))
    for before, after in zip(plain.parts, used.parts, strict=True):
        np.testing.assert_array_equal(before.T_object_part, after.T_object_part)


# Members of a pallet, and what moves them.


ROLES = {
    "epal1": {"deck": 5, "cross": 3, "block": 9, "base": 3},
    "epal2": {"deck": 9, "cross": 3, "block": 9, "base": 5},
    "epal7": {"deck": 5, "cross": 3, "block": 3, "base": 3, "bracket": 18},
    "gma_48x40": {"deck": 7, "stringer": 3, "base": 5},
    "plastic_runners": {"moulded": 13},
}


@pytest.mark.parametrize("name", ROLES)
def test_each_piece_has_its_role(name: str) -> None:
    assert Counter(member.role for member in members_of(catalog_object(name))) == ROLES[name]


def test_boards_are_sorted_across_their_length() -> None:
    for name, axis in (("epal1", 1), ("epal2", 0)):
        members = members_of(catalog_object(name))
        places = [members[index].centre[axis] for index in in_order(members, "deck")]
        assert places == sorted(places)
        assert len(set(places)) == len(places)


def test_a_base_frame_runs_both_ways_and_skids_do_not() -> None:
    for name, expected in (("epal1", True), ("epal2", False)):
        members = members_of(catalog_object(name))
        assert parallel(members, in_order(members, "base")) is expected


def test_moving_a_member_takes_along_what_sticks_to_it() -> None:
    member = members_of(catalog_object("epal1"))[0]
    moved = member.with_parts(member.body).moved((0.01, -0.02), np.pi / 2)
    assert len(moved.parts) == 2
    for part in moved.parts:
        moved_by = part.T_object_part[:3, 3] - member.centre
        np.testing.assert_allclose(moved_by, [0.01, -0.02, 0.0], atol=1e-12)
        np.testing.assert_allclose(part.T_object_part[:3, 0], [0, 1, 0], atol=1e-12)


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
