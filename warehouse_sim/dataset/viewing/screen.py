"""Whether a window can be opened here."""

import os
import sys

from warehouse_sim.errors import InputError

_SCREENS = ("DISPLAY", "WAYLAND_DISPLAY")


def require_screen(viewer: str, remedy: str) -> None:
    """Reject a viewer where there is no display.

    Args:
        viewer: Its name.
        remedy: What to do without, as it reads after a semicolon.

    Raises:
        InputError: There is none.
    """
    if sys.platform.startswith("linux") and not any(map(os.environ.get, _SCREENS)):
        raise InputError(f"no screen for {viewer}: {' and '.join(_SCREENS)} are not set; {remedy}")
