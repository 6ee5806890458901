import numpy as np
import pytest

from tests.catalog.covering import shipped, volume
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.building.conveyor import CONVEYORS
from warehouse_sim.catalog.building.dock import DOOR_SIZE, OPEN_DOOR_SIZE, SEAL_SIZE, TRAILER_SIZE
from warehouse_sim.catalog.building.shell import (
    OPENING_HEIGHT,
    OPENING_WIDTH,
    WALL_SIZE,
    profile,
    profile_points,
    profiled_solid,
)
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.geometry.separation import BoxStack


def test_a_profiled_solid_has_the_volume_between_its_lines() -> None:
    x = np.array([0.0, 1.0, 3.0])
    mesh = profiled_solid(x, np.zeros(3), np.array([1.0, 2.0, 2.0]), 0.5)
    assert volume(mesh) == pytest.approx((1.5 + 4.0) * 0.5)


def test_ribs_repeat_every_200_mm_and_are_even() -> None:
    x = np.linspace(-0.5, 0.5, 101)
    np.testing.assert_allclose(profile(x + 0.2), profile(x), atol=1e-6)
    np.testing.assert_allclose(profile(-x), profile(x), atol=1e-6)
    assert (profile(np.array([0.0, 0.1])) == [0.0, 1.0]).all()


def test_folds_of_a_piece_are_those_of_the_whole_sheet() -> None:
    piece = profile_points(0.07, 0.75)
    assert (piece[0], piece[-1]) == (0.07, 0.75)
    whole = profile_points(-1.0, 1.0)
    assert all(np.abs(whole - at).min() < 1e-9 for at in piece[1:-1])
    assert np.diff(piece).min() > 0.0


def test_a_dock_module_is_open_where_the_door_goes() -> None:
    module = catalog_object("wall_module_dock")
    floor = -WALL_SIZE[2] / 2
    opening = OrientedBox(
        make_transform(translation=np.array([0.0, 0.0, floor + OPENING_HEIGHT / 2])),
        np.array([OPENING_WIDTH - 1e-6, 1.0, OPENING_HEIGHT - 1e-6]),
    )
    assert BoxStack.of(module.collision).clear_of(opening, 0.0)
    vertices = module.mesh().vertices
    inside = (np.abs(vertices[:, 0]) < OPENING_WIDTH / 2 - 1e-9) & (vertices[:, 2] < floor + OPENING_HEIGHT - 1e-9)
    assert not inside.any()


@pytest.mark.parametrize("name", ["floor_slab_jointed", "floor_slab_epoxy"])
def test_joints_are_sawn_into_the_slab_every_6_m(name: str) -> None:
    panels = catalog_object(name).parts[0].placed().vertices
    edges = np.unique(np.round(panels[:, 0], 6))
    np.testing.assert_allclose(np.diff(edges)[1::2], 0.01, atol=1e-6)
    np.testing.assert_allclose((edges[1:-1:2] + edges[2:-1:2]) / 2, np.arange(-18.0, 19.0, 6.0), atol=1e-6)
    assert panels[:, 2].max() - panels[:, 2].min() == pytest.approx(0.02)
    assert catalog_object(name).parts[1].material == "floor_joint"


SIZES = {
    "floor_slab": ("floor", (48.0, 48.0, 0.2)),
    "floor_slab_jointed": ("floor", (48.0, 48.0, 0.2)),
    "floor_slab_epoxy": ("floor", (48.0, 48.0, 0.2)),
    "wall": ("wall", (48.0, 0.2, 9.0)),
    "wall_clad": ("wall", (48.0, 0.2, 9.0)),
    "wall_module": ("wall", (6.0, 0.2, 9.0)),
    "wall_module_dock": ("wall", (6.0, 0.2, 9.0)),
    "column_steel": ("column", (0.5, 0.5, 9.0)),
    "column_concrete": ("column", (0.4, 0.4, 9.0)),
    "column_guard": ("guard", (0.62, 0.62, 1.1)),
    "ceiling": ("ceiling", (48.0, 48.0, 0.24)),
    "roof_truss": ("ceiling", (48.0, 0.2, 1.8)),
    "highbay_luminaire": ("luminaire", (1.2, 0.32, 0.09)),
    "luminaire_round": ("luminaire", (0.36, 0.36, 0.21)),
    "luminaire_trunking": ("luminaire", (2.9, 0.08, 0.09)),
    "dock_door_closed": ("door", (3.05, 0.16, 3.5)),
    "dock_door_open": ("door", (3.05, 3.35, 3.5)),
    "dock_leveller": ("dock", (2.0, 2.5, 0.01)),
    "dock_bumper": ("dock", (0.25, 0.1, 0.5)),
    "drive_in_door": ("door", (4.2, 0.14, 4.4)),
    "dock_seal": ("dock", (3.35, 0.2, 3.3)),
    "trailer": ("trailer", (2.55, 13.62, 2.7)),
    "roller_conveyor": ("conveyor", (2.0, 0.64, 0.75)),
    "pallet_conveyor": ("conveyor", (2.4, 1.02, 0.5)),
    "extinguisher": ("fire_equipment", (0.2, 0.172, 0.52)),
    "fire_hose_cabinet": ("fire_equipment", (0.7, 0.25, 0.7)),
    "fire_sign": ("sign", (0.3, 0.01, 0.3)),
    "exit_sign": ("sign", (0.6, 0.01, 0.3)),
    "mandatory_sign": ("sign", (0.4, 0.01, 0.4)),
    "rubbish_bin": ("bin", (0.58, 0.73, 1.065)),
    "guard_rail": ("guard", (2.0, 0.16, 1.1)),
    **{f"aisle_sign_{number:02d}": ("sign", (0.6, 0.02, 0.6)) for number in range(1, 13)},
    **{f"floor_label_{number:02d}": ("sign", (0.4, 0.2, 0.001)) for number in range(1, 9)},
    "corner_marking": ("marking", (0.3, 0.3, 0.001)),
    "keep_clear_marking": ("marking", (2.4, 1.2, 0.001)),
    "crossing_marking": ("marking", (4.4, 1.6, 0.001)),
    **{
        f"lane_line_{colour}_{mm}": ("marking", (mm / 1000, 0.1, 0.001))
        for colour in ("yellow", "white")
        for mm in (1000, 3000, 6000)
    },
}

BUILDING = shipped("building")
FIRST = {201, 202, 203}


def test_outer_size_and_class() -> None:
    for name in SIZES:
        model = catalog_object(name)
        class_name, size = SIZES[name]
        assert model.class_name == class_name, name
        np.testing.assert_allclose(model.size, size, err_msg=name)


def test_every_object_of_the_building_is_measured_here() -> None:
    assert set(BUILDING) - set(SIZES) == {"tyre_mark_straight", "tyre_mark_curve"}


def test_numbers_are_those_of_the_building() -> None:
    numbers = {name: catalog_object(name).obj_id for name in BUILDING}
    assert {numbers[name] for name in ("floor_slab", "wall", "highbay_luminaire")} == FIRST
    assert all(130 <= number <= 169 or 400 <= number <= 499 for number in numbers.values() if number not in FIRST)


def test_no_object_has_more_parts_than_a_drawer_bears() -> None:
    assert max(len(catalog_object(name).parts) for name in BUILDING) <= 24


def test_the_number_of_an_aisle_reads_the_same_from_both_sides() -> None:
    """Its ink on one face is that of the other after half a turn about z; and 1 stands to the right of 0."""
    sign = catalog_object("aisle_sign_01")
    ink = next(part for part in sign.parts if part.material == "sign_white").placed().vertices
    front, back = (ink[side * ink[:, 1] > 0.009] for side in (-1, 1))
    turned = {tuple(row) for row in np.round(back[:, [0, 2]] * [-1, 1], 6) + 0.0}
    assert turned == {tuple(row) for row in np.round(front[:, [0, 2]], 6) + 0.0}
    # Seen from -y, +x is to the right: the 1, which has no bar on its left, ends at the right edge.
    assert front[:, 0].max() > 0.2 - 0.03
    assert front[:, 0].min() < -0.2


@pytest.mark.parametrize("name", CONVEYORS)
def test_rollers_share_one_mesh_and_keep_their_pitch_across_a_joint(name: str) -> None:
    kind, model = CONVEYORS[name], catalog_object(name)
    rollers = [part for part in model.parts if part.scale[0] == kind.roller]
    assert len({part.mesh for part in rollers}) == 1
    x = np.sort([part.T_object_part[0, 3] for part in rollers])
    np.testing.assert_allclose(np.diff(x), kind.pitch)
    assert kind.length - (x[-1] - x[0]) == pytest.approx(kind.pitch)


@pytest.mark.parametrize("name", CONVEYORS)
def test_a_load_rests_on_the_rollers_above_all_else(name: str) -> None:
    kind, model = CONVEYORS[name], catalog_object(name)
    tops = sorted(float(box.corners()[:, 2].max()) for box in model.collision)
    assert tops[-1] == pytest.approx(kind.height / 2)
    assert tops[-2] == pytest.approx(kind.height / 2 - 0.005)


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
