from collections import Counter

import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.pallets.wear.damage import in_order, members_of, parallel

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
