"""Options that have a new name: a command line written before is rejected with the name to use."""

from collections.abc import Sequence

from warehouse_sim.errors import InputError

RENAMED = {
    "--icp.looks": "--icp.rounds",
    "--icp.squash-start": "--icp.anisotropy-start",
    "--icp.squash-least": "--icp.anisotropy-least",
    "--icp.still": "--icp.step-tolerance",
}
"""Old name -> new name."""


def reject_renamed(arguments: Sequence[str]) -> None:
    """Reject a command line that uses an old name.

    Raises:
        InputError: Names the old and the new option.
    """
    for argument in arguments:
        option = argument.partition("=")[0].replace("_", "-")
        if option in RENAMED:
            raise InputError(f"{option} is now called {RENAMED[option]}; its values are the same")
