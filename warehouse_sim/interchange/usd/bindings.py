"""OpenUSD's Python modules, imported when a scene is written or read, and names that its prims may have."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import Any

from warehouse_sim.optional import require


@dataclass(frozen=True)
class Bindings:
    """The modules of ``pxr`` that scenes need, without their prefix ``Usd``."""

    Gf: Any
    Sdf: Any
    Tf: Any
    Vt: Any
    Usd: Any
    Geom: Any
    Lux: Any
    Physics: Any
    Semantics: Any
    Shade: Any


@cache
def bindings() -> Bindings:
    """Return OpenUSD's modules.

    Raises:
        MissingPackageError: usd-core is not installed.
    """
    plain = {name: f"pxr.{name}" for name in ("Gf", "Sdf", "Tf", "Vt", "Usd")}
    domains = {name: f"pxr.Usd{name}" for name in ("Geom", "Lux", "Physics", "Semantics", "Shade")}
    return Bindings(**{name: require(path, "interchange", "for USD") for name, path in (plain | domains).items()})


def prim_names(names: Iterable[str]) -> dict[str, str]:
    """Return a valid prim name for each of ``names``; no two share one, not even in upper and lower case."""
    found: dict[str, str] = {}
    taken: set[str] = set()
    for name in names:
        valid = candidate = bindings().Tf.MakeValidIdentifier(name)
        number = 1
        while candidate.lower() in taken:
            number += 1
            candidate = f"{valid}_{number}"
        taken.add(candidate.lower())
        found[name] = candidate
    return found
