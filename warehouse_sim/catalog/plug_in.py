"""What an object that a plug-in brings must keep to, so that it fits beside those of the catalog."""

from typing import Any

from warehouse_sim.catalog.custom_config import FIRST_OBJ_ID
from warehouse_sim.catalog.materials import materials
from warehouse_sim.errors import ConfigError
from warehouse_sim.schema import ObjectModel


def require_fitting(name: str, model: Any) -> None:
    """Check what the builder of a plug-in returned for ``name``.

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
