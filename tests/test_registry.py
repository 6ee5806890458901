import pytest

from warehouse_sim.errors import UnknownNameError, WarehouseSimError
from warehouse_sim.registry import Registry


def test_names_are_imported_on_use() -> None:
    registry = Registry("thing")
    registry.add("pi", "math:pi")
    assert registry.get("pi") == 3.141592653589793
    assert registry.names() == ["pi"]


def test_unknown_names_list_the_known_ones() -> None:
    registry = Registry("thing")
    registry.add("pi", "math:pi")
    with pytest.raises(UnknownNameError, match=r"unknown thing 'po'; known: pi"):
        registry.get("po")


def test_a_name_cannot_be_taken_twice() -> None:
    registry = Registry("thing")
    registry.add("pi", "math:pi")
    with pytest.raises(WarehouseSimError, match="registered twice"):
        registry.add("pi", "math:tau")
