"""Pallets: wooden ones board by board, plastic ones as moulded, each with every pocket that forks can enter.

Frame of all: origin at the centre of the bounding box, x along the longer edge, z up.
"""

from warehouse_sim.catalog.pallets import block_pallet, plans, plastic, stringer_pallet
from warehouse_sim.schema import ObjectModel

LENGTH, WIDTH, HEIGHT = 1.2, 0.8, 0.144
"""Outer edges of the EPAL 1 pallet (m)."""
Plan = block_pallet.BlockPallet | stringer_pallet.StringerPallet | plastic.RunnerPallet | plastic.FootPallet
PALLETS: dict[str, tuple[Plan, str, str]] = {
    "epal1": (plans.EPAL1, "pallet_wood", "pallet_block"),
    "epal1_new": (plans.EPAL1, "pallet_wood_new", "pallet_block"),
    "epal1_grey": (plans.EPAL1, "pallet_wood_grey", "pallet_block_grey"),
    "epal2": (plans.EPAL2, "pallet_wood", "pallet_block"),
    "epal3": (plans.EPAL3, "pallet_wood", "pallet_block"),
    "epal6": (plans.EPAL6, "pallet_wood", "pallet_block"),
    "epal7": (plans.EPAL7, "pallet_wood", "pallet_block"),
    "gma_48x40": (stringer_pallet.GMA, "pallet_wood", "pallet_wood"),
    "blue_block_1200x1000": (plans.BLUE_BLOCK, "pallet_blue", "pallet_blue"),
    "plastic_runners": (plastic.RUNNERS, "plastic_grey", ""),
    "plastic_runners_blue": (plastic.RUNNERS, "plastic_blue", ""),
    "plastic_nestable": (plastic.FEET, "plastic_black", ""),
    "plastic_nestable_grey": (plastic.FEET, "plastic_grey", ""),
}
"""Catalog name -> plan, material of boards or plastic, and of blocks; looks of one geometry share its obj_id."""


def pallet(name: str) -> ObjectModel:
    """Build the pallet called ``name``."""
    return built(name, *PALLETS[name])


def built(name: str, plan: Plan, board: str, block: str) -> ObjectModel:
    """Return the pallet of a plan.

    Args:
        name: What it is called.
        plan: What to build.
        board: Material of the boards, or of what is moulded.
        block: Material of wooden blocks and stringers.
    """
    match plan:
        case block_pallet.BlockPallet():
            return block_pallet.build(plan, name, board, block)
        case stringer_pallet.StringerPallet():
            return stringer_pallet.build(plan, name, board, block)
        case plastic.RunnerPallet():
            return plastic.on_runners(plan, name, board)
        case plastic.FootPallet():
            return plastic.on_feet(plan, name, board)
