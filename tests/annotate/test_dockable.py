from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.annotate.dockable import accessibility, entries_of
from warehouse_sim.annotate.trucks import DRIVE, TRUCKS
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.parts import solid_box
from warehouse_sim.catalog.traffic.truck_pieces import FORK_LENGTH
from warehouse_sim.geometry.pose import invert, make_transform, rotation_x, rotation_z, transform_points
from warehouse_sim.schema import FREE, UNDER_A_STACK, ObjectInstance, ObjectModel, SceneSpec

PALLET = catalog_object("epal1")
HEIGHT = 0.144
TRUCK = TRUCKS["counterbalance"]
NAMES = ("-x", "+x", "-y", "+y")


def block(class_name: str, size, instance_id: int, at, yaw: float = 0.0) -> tuple[ObjectModel, ObjectInstance]:
    name = f"{class_name} {instance_id}"
    model = ObjectModel(name, class_name, 900 + instance_id, np.array(size), (), (solid_box(size),))
    return model, ObjectInstance(instance_id, name, make_transform(rotation_z(yaw), np.array(at, dtype=float)))


def pallet(instance_id: int = 1, at=(0.0, 0.0, HEIGHT / 2), yaw: float = 0.0, group: int = 1) -> ObjectInstance:
    return ObjectInstance(instance_id, PALLET.name, make_transform(rotation_z(yaw), np.array(at)), True, group)


ALONE = pallet()


def scene(*others, pallets=(ALONE,), aisle=None) -> SceneSpec:
    floor = block("floor", (60.0, 60.0, 0.2), 99, (0.0, 0.0, -0.1))
    models = {PALLET.name: PALLET} | {model.name: model for model, _ in (floor, *others)}
    instances = (*pallets, *(item for _, item in (floor, *others)))
    return SceneSpec(0, 0, models, {}, instances, (), (), settled=True, aisle=aisle)


def faces(*others, truck=TRUCK, **more) -> dict[str, str]:
    return dict(accessibility(scene(*others, **more), truck)[1].faces)


def test_a_pallet_alone_on_the_floor_is_taken_from_all_sides() -> None:
    for name in TRUCKS:
        assert faces(truck=TRUCKS[name]) == dict.fromkeys(NAMES, FREE), name


def test_an_upright_blocks_the_face_whose_tines_it_stands_before() -> None:
    """The tines of the -x side run at 186.25 mm, 100 mm wide: from 136.25 to 236.25 mm beside the middle."""
    for y, blocked in ((0.2363 + 0.05, False), (0.2363 + 0.047, True), (0.1362 - 0.05, False), (0.1362 - 0.047, True)):
        # Lower than the truck's ground clearance, so that only the tines can meet it, and taller than their underside.
        post = block("rack", (0.1, 0.1, 0.055), 50, (-1.0, y, 0.0275))
        assert faces(post)["-x"] == ("blocked by rack" if blocked else FREE), y


def test_what_stands_behind_the_pallet_meets_the_tips() -> None:
    """The tips stop 1.10 m behind the face, or at the far side of a pallet that is 0.80 m deep."""
    for gap, verdict in ((0.002, FREE), (-0.002, "blocked by pallet")):
        behind = pallet(2, (0.0, 0.8 + gap, HEIGHT / 2), group=2)
        assert faces(pallets=(pallet(), behind))["-y"] == verdict
    assert faces(pallets=(pallet(), pallet(2, (1.21, 0.0, HEIGHT / 2), group=2)))["-x"] == FREE


def test_a_truck_that_stops_early_keeps_its_mast_off_an_overhang() -> None:
    """From the 1.2 m wide side the heel stops 0.35 m before the face: 1.15 m of tines in 0.8 m of pallet."""
    for over, verdict in ((0.348, FREE), (0.352, "mast blocked by its own load")):
        model, load = block("carton", (1.2, 0.8 + 2 * over, 0.4), 50, (0.0, 0.0, HEIGHT + 0.2))
        assert faces((model, replace(load, group=1)))["-y"] == verdict


def test_people_and_walls_take_the_room_of_the_truck() -> None:
    """It stands 1.25 m before the face with its heel, 1.99 m long: its rear end is 3.24 m away."""
    person = block("person", (0.3, 0.3, 1.7), 50, (-2.5, 0.0, 0.85))
    found = faces(person)
    assert found == {"-x": "no room for the truck: person", "+x": FREE, "-y": FREE, "+y": FREE}
    for x, verdict in ((-0.6 - 3.25 - 0.05, FREE), (-0.6 - 3.23 - 0.05, "no room for the truck: building")):
        assert faces(block("building", (0.1, 10.0, 5.0), 50, (x, 0.0, 2.5)))["-x"] == verdict


def test_a_lamp_above_is_in_the_way_of_a_raised_mast_only() -> None:
    lamp = block("luminaire", (0.4, 0.4, 0.1), 50, (-0.8, 0.0, 2.5))
    assert faces(lamp)["-x"] == FREE
    high = block("rack", (1.2, 0.8, 2.0), 51, (0.0, 0.0, 1.0))
    raised = (pallet(at=(0.0, 0.0, 2.0 + HEIGHT / 2)),)
    assert faces(high, pallets=raised)["-x"] == FREE
    assert faces(high, lamp, pallets=raised)["-x"] == "mast blocked by luminaire"


def test_forks_go_up_to_a_height() -> None:
    shelf = block("rack", (1.2, 0.8, 6.1), 51, (0.0, 0.0, 3.05))
    raised = (pallet(at=(0.0, 0.0, 6.1 + HEIGHT / 2)),)
    assert set(faces(shelf, pallets=raised).values()) == {"higher than the forks go"}
    assert set(faces(shelf, pallets=raised, truck=TRUCKS["reach"]).values()) == {FREE}


def test_its_own_load_hangs_over() -> None:
    """The backrest stops with the heel, 50 mm before the face."""
    for over, verdict in ((0.048, FREE), (0.052, "mast blocked by its own load")):
        model, load = block("carton", (1.2 + 2 * over, 0.8, 0.4), 50, (0.0, 0.0, HEIGHT + 0.2))
        assert faces((model, replace(load, group=1)))["-x"] == verdict


def test_the_truck_comes_from_the_aisle() -> None:
    got = faces(aisle=(-6.0, -0.6, -3.0, 3.0))
    assert got == {"-x": FREE} | dict.fromkeys(("+x", "-y", "+y"), "outside the aisle")
    # 3.24 m of it, and a tenth of a metre over its edge.
    assert faces(aisle=(-0.6 - 3.13, -0.6, -3.0, 3.0))["-x"] == "outside the aisle"
    assert faces(aisle=(-0.6 - 3.15, -0.6, -3.0, 3.0))["-x"] == FREE


def test_the_truck_drives_through_a_free_lane() -> None:
    lane, aisle = (pallet(at=(5.0, 0.0, HEIGHT / 2)),), (-6.0, -0.6, -3.0, 3.0)
    assert faces(pallets=lane, aisle=aisle)["-x"] == FREE
    before = pallet(2, (1.0, 0.0, HEIGHT / 2), group=2)
    assert faces(pallets=(*lane, before), aisle=aisle)["-x"].endswith("pallet")
    assert faces(pallets=lane, aisle=aisle, truck=TRUCKS["very_narrow"])["-x"] == "outside the aisle"


def test_stacks_are_told() -> None:
    load = block("carton", (1.0, 0.7, 0.5), 50, (0.0, 0.0, HEIGHT + 0.25))
    load = load[0], replace(load[1], group=1)
    upper = pallet(2, (0.0, 0.0, 1.5 * HEIGHT + 0.501), group=2)
    alone = pallet(3, (0.0, 8.0, HEIGHT / 2), group=3)
    found = accessibility(scene(load, pallets=(pallet(), upper, alone)), TRUCK)
    assert [found[number].stacked for number in (1, 2, 3)] == [True, True, False]
    assert set(found[1].faces.values()) == {UNDER_A_STACK}
    assert set(found[2].faces.values()) == set(found[3].faces.values()) == {FREE}


def test_a_pallet_in_the_rack_above_is_no_stack() -> None:
    beam = block("rack", (1.2, 0.1, 0.1), 50, (0.0, 0.0, 1.45))
    upper = pallet(2, (0.0, 0.0, 1.5 + HEIGHT / 2), group=2)
    found = accessibility(scene(beam, pallets=(pallet(), upper)), TRUCK)
    assert not found[1].stacked
    assert not found[2].stacked


def test_a_leaning_pallet_is_not_entered() -> None:
    for lean, verdicts in ((4.0, {FREE}), (6.0, {"leaning"})):
        T = make_transform(rotation_x(np.deg2rad(lean)), np.array([0.0, 0.0, 0.3]))
        assert set(faces(pallets=(replace(pallet(), T_world_object=T),)).values()) == verdicts


def test_goods_have_no_faces() -> None:
    assert 50 not in accessibility(scene(block("carton", (0.4, 0.3, 0.3), 50, (3.0, 3.0, 0.15))), TRUCK)


@pytest.mark.parametrize("seed", range(2))
def test_driving_in_step_by_step_meets_the_same(seed: int) -> None:
    """Points in every obstacle, and the truck moved a centimetre at a time: none in it where the face is free."""
    rng = np.random.default_rng(seed)
    others = []
    for number in range(8):
        at = (*rng.uniform(-4.0, 4.0, 2), rng.uniform(0.1, 1.5))
        others.append(block("carton", rng.uniform(0.1, 0.6, 3), 50 + number, at, rng.uniform(0, 3)))
    sampled = scene(*others, pallets=(pallet(yaw=rng.uniform(0, 3)),))
    found = accessibility(sampled, TRUCK)[1].faces
    for entry in entries_of(sampled):
        still = list(TRUCK.tines(entry.height, entry.offsets, -DRIVE))
        still += [box for pieces in (TRUCK.mast, TRUCK.body) for box in TRUCK.swept(pieces, entry.height, -DRIVE)]
        deepest = 0.0
        for model, item in others:
            points = rng.uniform(-0.5, 0.5, (1000, 3)) * model.size
            T_entry_points = invert(entry.T_world_entry) @ item.T_world_object
            for back in np.arange(0.0, DRIVE, 0.02):
                seen = transform_points(T_entry_points, points) + np.array([back, 0.0, 0.0])
                for box in still:
                    inside = box.size / 2 - np.abs(transform_points(invert(box.T_parent_box), seen))
                    deepest = max(deepest, float(inside.min(axis=1).max()))
        assert (deepest > 0.0) <= (found[entry.face] != FREE), entry.face
        assert (found[entry.face] != FREE) <= (deepest > -0.05), entry.face


def test_the_reach_truck_is_the_catalogs_with_its_mast_pushed_out() -> None:
    """From tips to arms and from arms to rear it is as long as the catalog's, but for the 0.75 m of the mast."""
    boxes = [box.corners() for box in catalog_object("reach_truck").collision]
    tips = max(corners[:, 0].max() for corners in boxes)
    arms = max(corners[:, 0].max() for corners in boxes if corners[:, 0].max() < tips - 0.5)
    rear = min(corners[:, 0].min() for corners in boxes)
    body = TRUCKS["reach"].body
    front = max(piece.front for piece in body)
    assert FORK_LENGTH - front == pytest.approx(tips - arms + 0.75)
    assert front - min(piece.rear for piece in body) == pytest.approx(arms - rear)
    assert {piece.behind for piece in body} == {0.75}
    # It drives the last 0.45 m; from rear to face it needs 2.55 m.
    assert TRUCKS["reach"].rear == pytest.approx(-2.55)
