"""Under which licence a dataset may be used: what this package made of its own, and what users brought."""

from collections.abc import Iterable, Mapping

OWN = "Apache-2.0"
"""Of this package, its textures and photometric files, and of what it makes of them alone."""
OWNERS = "as its owner says"
"""Of what users brought: only they know."""
DATA, TEXTURES = "data", "textures"


def data_licences(textures: str, brought: Iterable[str], plugins: Iterable[str]) -> dict[str, str]:
    """Return what is licensed how in a generated dataset.

    Args:
        textures: Licence of the shipped textures.
        brought: Files of the user's own that the recipe names: objects, goods, photometry.
        plugins: Packages of others that took part.
    """
    others = [*sorted(set(brought)), *(f"plug-in {name}" for name in sorted(plugins))]
    return {DATA: OWN, TEXTURES: textures} | dict.fromkeys(others, OWNERS)


def licence_text(licences: Mapping[str, str]) -> str:
    """Return what a card says of the licences, as Markdown."""
    if not licences:
        return "Not stated by who made it."
    others = [name for name in licences if name not in (DATA, TEXTURES)]
    lines = ["The data may be used like the package that made it.\n"] if licences.get(DATA) == OWN else []
    lines += [f"- {name}: {licence}" for name, licence in licences.items()]
    if others and DATA in licences:
        lines.append(
            "\nWhat shows things that users brought is also bound to what their owners allow; all else is under the "
            f"licence of the data, {licences[DATA]}."
        )
    return "\n".join(lines)
