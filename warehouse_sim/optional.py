"""Import packages that an installation may lack, with one clear line when it does."""

from importlib import import_module
from types import ModuleType

from warehouse_sim.errors import MissingPackageError


def require(module: str, extra: str, purpose: str) -> ModuleType:
    """Import ``module`` or say which extra of warehouse-sim brings it.

    Args:
        module: Dotted name to import.
        extra: Extra of this package that installs it.
        purpose: What needs it, as it reads after "is needed".

    Raises:
        MissingPackageError: The module cannot be imported.
    """
    try:
        return import_module(module)
    except ImportError as error:
        raise MissingPackageError(
            f"{module} is needed {purpose} but cannot be imported ({error}); "
            f"install it with: pip install 'warehouse-sim[{extra}]'"
        ) from error
