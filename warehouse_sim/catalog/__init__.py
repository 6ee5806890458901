"""Parametric objects to real standards: pallets, cartons, racks, the building and what their surfaces are made of."""

from functools import cache
from typing import Any

from warehouse_sim.catalog.custom_config import FIRST_OBJ_ID
from warehouse_sim.catalog.materials import materials, materials_of
from warehouse_sim.catalog.own_files import is_file_name, object_of_files, reject_other_file
from warehouse_sim.catalog.shipped import SHIPPED
from warehouse_sim.errors import ConfigError
from warehouse_sim.registry import Registry
from warehouse_sim.schema import ObjectModel

CATALOG = Registry("catalog object")
"""Name -> builder: a function that takes the name and returns the ``ObjectModel``."""

for _name, _builder in SHIPPED.items():
    CATALOG.add(_name, _builder)


def catalog_names() -> list[str]:
    """Return the names of all catalog objects, those of installed plug-ins too, sorted."""
    return CATALOG.names()


@cache
def shipped_classes() -> frozenset[str]:
    """Return the classes of the package's own objects."""
    return frozenset(catalog_object(name).class_name for name in SHIPPED)


def catalog_object(name: str) -> ObjectModel:
    """Return the catalog object called ``name``; the same object each time, so that scenes share geometry.

    An object of a user's files is read again when one of them has changed.

    Args:
        name: Registered name, or the .yaml or mesh file of a user's own object (docs/custom_objects.md).

    Raises:
        UnknownNameError: The name is not registered.
        ConfigError: The file does not describe an object, or is of another kind; a plug-in's object does not fit.
    """
    if name not in SHIPPED:
        if is_file_name(name):
            return object_of_files(name)
        if name not in CATALOG.names():
            reject_other_file(name)
    return _registered(name)


@cache
def _registered(name: str) -> ObjectModel:
    model: ObjectModel = CATALOG.get(name)(name)
    if name not in SHIPPED:
        _require_fitting(name, model)
    return model


def _require_fitting(name: str, model: Any) -> None:
    """Check that what the builder of a plug-in returned for ``name`` fits beside the objects of the catalog.

    Raises:
        ConfigError: It is no model of that name, has a number of the catalog's, or a material that nobody brings.
    """
    where = f"catalog object {name!r} of a plug-in"
    if not isinstance(model, ObjectModel):
        raise ConfigError(f"{where}: its builder must return an ObjectModel, found {type(model).__name__}")
    if model.name != name:
        raise ConfigError(f"{where}: its model is called {model.name!r}; a model has the name it is registered by")
    if model.obj_id < FIRST_OBJ_ID:
        raise ConfigError(f"{where}: obj_id must be {FIRST_OBJ_ID} or more, found {model.obj_id}")
    own, shipped = {material.name for material in model.materials}, materials()
    for material in sorted(own & shipped.keys()):
        raise ConfigError(f"{where}: it brings a material {material!r}, which the catalog has; choose another name")
    for part in model.parts:
        if part.material not in own and part.material not in shipped:
            raise ConfigError(f"{where}: list its material {part.material!r} in ObjectModel.materials")


__all__ = ["CATALOG", "catalog_names", "catalog_object", "materials", "materials_of", "shipped_classes"]
