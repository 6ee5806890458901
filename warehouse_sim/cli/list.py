"""``warehouse-sim list``: the names that other commands take."""

import sys

from rich.console import Console
from rich.table import Table

from warehouse_sim.catalog import CATALOG
from warehouse_sim.dataset.formats import FORMATS
from warehouse_sim.estimators import DETECTORS, ESTIMATORS, SEGMENTERS
from warehouse_sim.optional import missing
from warehouse_sim.render import BACKENDS
from warehouse_sim.resources import recipe_names, suite_names
from warehouse_sim.sensors import SENSORS
from warehouse_sim.sensors.rig import rig_names


def list_names() -> None:
    """Show recipes, catalog objects, sensors, rigs, backends, formats, suites, estimators and detectors."""
    kinds = {
        "recipes": recipe_names(),
        "catalog objects": CATALOG.names(),
        "sensors": SENSORS.names(),
        "rigs": rig_names(),
        "backends": BACKENDS.names(),
        "formats": FORMATS.names(),
        "suites": suite_names(),
        "estimators": ESTIMATORS.names(),
        "detectors": ["gt", *DETECTORS.names()],
        "segmenters": SEGMENTERS.names(),
    }
    # A file or a pipe has no width; tables are wider than the 80 columns that are taken for it.
    console = Console(highlight=False, width=None if sys.stdout.isatty() else 140)
    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    for kind, names in ((kind, names) for kind, names in kinds.items() if names):
        table.add_row(kind, ", ".join(names))
    console.print(table)
    if not missing("learn"):
        console.print(_estimators())
    print("next:   warehouse-sim preview demo")


def _estimators() -> Table:
    from warehouse_sim.estimators.overview import overview

    rows = [overview(name) for name in ESTIMATORS.names()]
    table = Table(box=None, padding=(0, 2, 0, 0))
    bundled = "bundled weights: with ground-truth masks and the camera they know"
    sizes = ", ".join(dict.fromkeys(size for row in rows for size in row.parameters))
    for heading in ("estimator", "reads", f"parameters: {sizes}", bundled):
        table.add_column(heading, no_wrap=heading == "estimator")
    for row in rows:
        counts = ", ".join(f"{count / 1e6:.1f} M" for count in row.parameters.values())
        table.add_row(row.name, row.inputs, counts, row.bundled or "none")
    return table
