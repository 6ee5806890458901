"""All that a suite can do to what an estimator is given, by name."""

from warehouse_sim.benchmark.disturbances.camera import CAMERA_ERRORS
from warehouse_sim.benchmark.disturbances.masks import MASK_ERRORS, Disturb, unnamed
from warehouse_sim.errors import UnknownNameError

UNNAMED = "class unknown"
DISTURBANCES: dict[str, Disturb] = MASK_ERRORS | {UNNAMED: unnamed} | CAMERA_ERRORS


def disturbance(name: str) -> Disturb:
    """Return what does it.

    Raises:
        UnknownNameError: There is none of that name.
    """
    if name not in DISTURBANCES:
        raise UnknownNameError("disturbance", name, list(DISTURBANCES))
    return DISTURBANCES[name]
