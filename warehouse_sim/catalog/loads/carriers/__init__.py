"""Carriers that are a unit load alone or with a pallet: boxes of mesh, roll containers, octabins, big bags, IBCs."""

from warehouse_sim.catalog.loads.carriers.big_bag import BIG_BAGS
from warehouse_sim.catalog.loads.carriers.gitterbox import GITTERBOXES
from warehouse_sim.catalog.loads.carriers.ibc import IBCS
from warehouse_sim.catalog.loads.carriers.octabin import OCTABINS
from warehouse_sim.catalog.loads.carriers.roll_container import ROLL_CONTAINERS

CARRIERS = {
    **dict.fromkeys(GITTERBOXES, "gitterbox:gitterbox"),
    **dict.fromkeys(ROLL_CONTAINERS, "roll_container:roll_container"),
    **dict.fromkeys(OCTABINS, "octabin:octabin"),
    **dict.fromkeys(BIG_BAGS, "big_bag:big_bag"),
    **dict.fromkeys(IBCS, "ibc:ibc"),
}
"""Catalog name -> module and builder in this folder."""
WITHOUT_PALLET = ("gitterbox", "roll_container")
"""Classes that stand on feet or wheels of their own; the others stand on a pallet."""

__all__ = ["BIG_BAGS", "CARRIERS", "GITTERBOXES", "IBCS", "OCTABINS", "ROLL_CONTAINERS", "WITHOUT_PALLET"]
