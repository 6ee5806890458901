"""Names of prims: USD allows letters, digits and underscores only, and our names hold more."""

from collections.abc import Iterable

from warehouse_sim.interchange.usd.bindings import bindings


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
