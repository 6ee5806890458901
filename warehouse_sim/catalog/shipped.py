"""The package's own objects by name, each with its builder."""

from collections.abc import Iterable, Mapping

from warehouse_sim.catalog.building.conveyor import CONVEYORS
from warehouse_sim.catalog.building.floor_marks import LINES
from warehouse_sim.catalog.building.safety import AISLE_SIGNS, FLOOR_LABELS
from warehouse_sim.catalog.loads.bulk import BIG_BAGS, IBCS, OCTABINS
from warehouse_sim.catalog.loads.cages import GITTERBOXES, ROLL_CONTAINERS
from warehouse_sim.catalog.loads.cartons import ALL_SKUS
from warehouse_sim.catalog.loads.drums import DRUMS
from warehouse_sim.catalog.loads.open_cartons import OPEN_CARTONS
from warehouse_sim.catalog.loads.sacks import SACK_SHAPES, SACKS
from warehouse_sim.catalog.loads.securing import CORNER_POSTS, SLIP_SHEETS, WRAPS
from warehouse_sim.catalog.loads.totes import TOTES
from warehouse_sim.catalog.pallets import PALLETS
from warehouse_sim.catalog.racks.cantilever import CANTILEVERS, LONG_GOODS
from warehouse_sim.catalog.racks.pallet_racks import FRAME_HEIGHTS, RACK_BEAMS, STEP_BEAMS
from warehouse_sim.catalog.racks.small_parts import BINS
from warehouse_sim.catalog.traffic.obstacles import CONES, FINE_CONES
from warehouse_sim.catalog.traffic.obstacles import WRAPS as HANGING_WRAPS
from warehouse_sim.catalog.traffic.people import PEOPLE, WORKERS_BY_NAME
from warehouse_sim.catalog.traffic.poses import ON_TRUCKS
from warehouse_sim.catalog.traffic.working import WORKING


def _built(folder: str, names: Mapping[str, Iterable[str]]) -> dict[str, str]:
    """Return name -> builder of a folder's objects, given by module and builder; a module's are called as theirs."""
    return {
        name: f"warehouse_sim.catalog.{folder}{target if ':' in target else f'{target}:{name}'}"
        for target, group in names.items()
        for name in group
    }


TRAFFIC = _built(
    "traffic.",
    {
        "people:person": PEOPLE,
        "people:worker": WORKERS_BY_NAME,
        "trucks": ("pallet_jack", "forklift", "reach_truck"),
        "obstacles": ("bollard", "floor_sign"),
        "obstacles:cone": CONES,
        "obstacles:traffic_cone": FINE_CONES,
        "obstacles:hanging_wrap": HANGING_WRAPS,
        "working:working_truck": WORKING,
    },
)
"""Catalog name -> builder of who and what moves through the aisles or stands in the way."""
WORKING_CLASSES = ("amr", "cart", "forklift", "pallet_jack", "person", "tugger")
"""Classes of who and what is at work in the aisles; a recipe can have them labelled."""
STANDING = {
    "bollard": ("bollard",),
    "cone": tuple(sorted(CONES)),
    "forklift": ("forklift", "reach_truck"),
    "pallet_jack": ("pallet_jack",),
    "person": tuple(sorted(PEOPLE)),
}
"""Class -> the catalog names of it that are sampled, each as often, where a recipe requires the class."""
FINE_STANDING = {
    **STANDING,
    "cone": tuple(sorted(FINE_CONES)),
    "pallet_jack": ("hand_pallet_truck",),
    "person": tuple(sorted(name for name, (_, pose) in WORKERS_BY_NAME.items() if pose not in (*ON_TRUCKS, "pushing"))),
}
"""The same of the finely divided ones; who pushes belongs to a truck."""

CLUTTER = _built(
    "",
    {
        "clutter": (
            *("waste_bin", "bucket", "canister", "pallet_box"),
            *("toolbox", "broom", "step_ladder", "hand_truck", "extension_reel"),
            *("film_roll", "film_rolls", "strap_roll", "flat_cartons", "open_carton", "wood_scraps", "film_heap"),
        )
    },
)
"""Catalog name -> builder of small things that stand about."""
CARRIERS = _built(
    "loads.",
    {
        "cages:gitterbox": GITTERBOXES,
        "cages:roll_container": ROLL_CONTAINERS,
        "bulk:octabin": OCTABINS,
        "bulk:big_bag": BIG_BAGS,
        "bulk:ibc": IBCS,
    },
)
"""Catalog name -> builder of carriers that are a unit load alone or with a pallet."""
_LOADS: dict[str, Iterable[str]] = {
    "cartons:carton": ALL_SKUS,
    "open_cartons:open_carton_of": OPEN_CARTONS,
    "totes:tote": TOTES,
    "drums:drum": DRUMS,
    "sacks:sack": (*SACKS, *SACK_SHAPES),
    "securing:slip_sheet": SLIP_SHEETS,
    "securing:corner_post": CORNER_POSTS,
    "securing:wrap": WRAPS,
}
_RACKS: dict[str, Iterable[str]] = {
    "pallet_racks:rack_frame": FRAME_HEIGHTS,
    "pallet_racks:rack_beam": RACK_BEAMS,
    "pallet_racks:step_beam": STEP_BEAMS,
    "accessories": (
        *("mesh_deck", "pallet_support_bar", "upright_guard", "rack_end_guard", "beam_label", "frame_label"),
        *("row_spacer", "load_notice"),
    ),
    "pallet_racks": ("drive_in_rail", "drive_in_tie"),
    "cantilever": ("cantilever_brace", *LONG_GOODS),
    "cantilever:cantilever_column": CANTILEVERS,
    "small_parts": ("shelf_bay", "platform_panel", "platform_column", "platform_railing"),
    "small_parts:storage_bin": BINS,
}
_BUILDING: dict[str, Iterable[str]] = {
    "shell": ("floor_slab", "wall", "wall_clad", "wall_module", "wall_module_dock"),
    "shell:jointed_slab": ("floor_slab_jointed", "floor_slab_epoxy"),
    "structure": (
        *("column_steel", "column_concrete", "column_guard", "ceiling", "roof_truss"),
        *("highbay_luminaire", "luminaire_round", "luminaire_trunking"),
    ),
    "dock": ("dock_door_closed", "dock_door_open", "dock_leveller", "dock_bumper", "dock_seal", "trailer"),
    "floor_marks": (
        *("corner_marking", "keep_clear_marking", "crossing_marking", "tyre_mark_straight", "tyre_mark_curve"),
    ),
    "floor_marks:lane_line": LINES,
    "safety": (
        *("drive_in_door", "extinguisher", "fire_hose_cabinet", "fire_sign", "exit_sign", "mandatory_sign"),
        *("rubbish_bin", "guard_rail"),
    ),
    "safety:aisle_sign": AISLE_SIGNS,
    "safety:floor_label": FLOOR_LABELS,
    "conveyor:conveyor": CONVEYORS,
}
SHIPPED = {
    **_built("", {"pallets:pallet": PALLETS}),
    **_built("loads.", _LOADS),
    **CARRIERS,
    **_built("racks.", _RACKS),
    **_built("building.", _BUILDING),
    **TRAFFIC,
    **CLUTTER,
}
"""Name -> builder. What is sampled by class is sampled from these, whatever is installed."""
