"""No module of the package reaches itself through its imports, whether they stand in functions or at the top."""

from graphlib import CycleError, TopologicalSorter

import grimp
import pytest


@pytest.fixture(scope="module")
def imports() -> dict[str, set[str]]:
    """Return what each module imports; a package counts as the module in its ``__init__``."""
    graph = grimp.build_graph("warehouse_sim", cache_dir=None)
    return {name: graph.find_modules_directly_imported_by(name) for name in graph.modules}


def test_modules_have_an_order(imports: dict[str, set[str]]) -> None:
    placed = list(TopologicalSorter(imports).static_order())
    assert placed.index("warehouse_sim.errors") < placed.index("warehouse_sim.api.dataset")


def test_imports_within_functions_count(imports: dict[str, set[str]]) -> None:
    assert "warehouse_sim.evaluation" in imports["warehouse_sim.api.estimates"]
    with pytest.raises(CycleError, match="nodes are in a cycle"):
        TopologicalSorter(imports | {"warehouse_sim.evaluation": {"warehouse_sim.api.dataset"}}).prepare()
