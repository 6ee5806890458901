"""``warehouse-sim catalog``: render the objects that scenes are made of."""

from pathlib import Path

import tyro

from warehouse_sim.cli.console import finish
from warehouse_sim.optional import require_extra


def catalog(names: tyro.conf.Positional[tuple[str, ...]] = (), out: Path = Path("catalog.png")) -> None:
    """Draw catalog objects one by one, each with its name and outer size.

    Args:
        names: Names of catalog objects, see ``warehouse-sim list``; all by default.
        out: PNG file to write.
    """
    require_extra("generate", "to draw objects")
    from warehouse_sim.generation.catalog_sheet import render_catalog_sheet

    render_catalog_sheet(out, names or None)
    finish(out, "preview", "demo")
