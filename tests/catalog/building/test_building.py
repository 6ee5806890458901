import numpy as np

from tests.catalog.covering import bare_distances, shipped
from warehouse_sim.catalog import catalog_object

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


def test_collision_boxes_cover_the_mesh_to_30_mm() -> None:
    for name in [name for name in BUILDING if catalog_object(name).collision]:
        assert bare_distances(catalog_object(name)).max() <= 0.030 + 1e-9, name


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
