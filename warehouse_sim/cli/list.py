"""``warehouse-sim list``: the names that other verbs take."""

from rich.console import Console
from rich.table import Table

from warehouse_sim.catalog import CATALOG
from warehouse_sim.dataset.writers import WRITERS
from warehouse_sim.estimators import ESTIMATORS
from warehouse_sim.render import BACKENDS
from warehouse_sim.resources import recipe_names, suite_names
from warehouse_sim.sensors import SENSORS
from warehouse_sim.sensors.rig import rig_names


def list_names() -> None:
    """Show recipes, catalog objects, sensors, rigs, backends, formats, estimators and suites."""
    kinds = {
        "recipes": recipe_names(),
        "catalog objects": CATALOG.names(),
        "sensors": SENSORS.names(),
        "rigs": rig_names(),
        "backends": BACKENDS.names(),
        "formats": WRITERS.names(),
        "estimators": ESTIMATORS.names(),
        "suites": suite_names(),
    }
    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    for kind, names in kinds.items():
        table.add_row(kind, ", ".join(names))
    Console(highlight=False).print(table)
    print("next:   warehouse-sim preview demo")
