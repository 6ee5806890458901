"""Name -> "module:attribute", imported on first use, open to third parties through entry points."""

from importlib import import_module
from importlib.metadata import entry_points
from typing import Any

from warehouse_sim.errors import UnknownNameError, WarehouseSimError


class Registry:
    """Resolve names of one kind of plug-in to the objects that implement them.

    A third party adds names by declaring entry points in the group ``warehouse_sim.<kind>``.

    Args:
        kind: What the names stand for, in the singular, as it reads in an error ("estimator").
        group: Entry point group; ``warehouse_sim.<kind>s`` with blanks as underscores by default.
    """

    def __init__(self, kind: str, group: str | None = None) -> None:
        self.kind = kind
        self.group = group or f"warehouse_sim.{kind.replace(' ', '_')}s"
        self._targets: dict[str, str] = {}
        self._scanned = False

    def add(self, name: str, target: str) -> None:
        """Register ``target`` ("package.module:Attribute") under ``name``; a taken name is an error."""
        if name in self._targets:
            raise WarehouseSimError(
                f"{self.kind} {name!r} is registered twice: {self._targets[name]} and {target}; rename one"
            )
        self._targets[name] = target

    def names(self) -> list[str]:
        """Return all known names, sorted."""
        self._scan_entry_points()
        return sorted(self._targets)

    def get(self, name: str) -> Any:
        """Import and return what ``name`` stands for.

        Raises:
            UnknownNameError: The name is not registered.
        """
        self._scan_entry_points()
        if name not in self._targets:
            raise UnknownNameError(self.kind, name, list(self._targets))
        module, _, attribute = self._targets[name].partition(":")
        return getattr(import_module(module), attribute)

    def _scan_entry_points(self) -> None:
        if self._scanned:
            return
        self._scanned = True
        for entry in entry_points(group=self.group):
            self.add(entry.name, entry.value)
