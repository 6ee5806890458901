"""Small things that stand about in halls and mean nothing: bins, buckets, tools, rolls, scraps, flattened cartons.

Sizes are those of common products. Origin at the centre of the bounding box, z up; all stand on their lowest faces.
"""

_HERE = "warehouse_sim.catalog.clutter"
CLUTTER = {
    **{name: f"{_HERE}.vessels:{name}" for name in ("waste_bin", "bucket", "canister", "pallet_box")},
    **{name: f"{_HERE}.tools:{name}" for name in ("toolbox", "broom", "step_ladder", "hand_truck", "extension_reel")},
    **{
        name: f"{_HERE}.packaging:{name}"
        for name in ("film_roll", "film_rolls", "strap_roll", "flat_cartons", "open_carton")
    },
    **{name: f"{_HERE}.packaging:{name}" for name in ("wood_scraps", "film_heap")},
}
"""Catalog name -> where its builder is."""

__all__ = ["CLUTTER"]
