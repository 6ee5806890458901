"""Settings that are given by name in Python, as options are on the command line."""

from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np

from warehouse_sim.config import from_mapping, to_mapping

T = TypeVar("T")


def settings_of(default: T, given: Mapping[str, Any], where: str) -> T:
    """Return settings with some of them given by name.

    Args:
        default: All settings.
        given: Values by name; settings within settings are mappings or settings themselves.
        where: What takes them, for messages.

    Raises:
        ConfigError: There is no such setting, or a value does not fit.
    """
    plain = {
        name: to_mapping(value.item() if isinstance(value, np.generic) else value) for name, value in given.items()
    }
    return from_mapping(type(default), to_mapping(default) | plain, where)
