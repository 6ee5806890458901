"""What a dataset will be licensed as: its recipe names the files of users, the manifest of assets says the rest."""

from collections.abc import Iterable, Iterator
from typing import Any

from warehouse_sim.catalog.mesh_files import SUFFIXES
from warehouse_sim.dataset.card.text import data_licences
from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.resources import data_folder

_BROUGHT = (".yaml", ".yml", ".ies", *SUFFIXES)
"""Endings by which a setting names a file instead of something that is shipped."""


def recipe_licences(recipe: dict[str, Any], plugins: Iterable[str]) -> dict[str, str]:
    """Return what is licensed how in a dataset of a resolved recipe.

    Args:
        recipe: As plain data.
        plugins: Third-party packages that take part.
    """
    named = [file for text in _texts(recipe) if (file := text.partition("#")[0]).lower().endswith(_BROUGHT)]
    return data_licences(texture_licence(), named, plugins)


def texture_licence() -> str:
    """Return the licence of the shipped textures, all of them where they differ (SPDX)."""
    files = read_json(data_folder("assets") / "manifest.json")["files"]
    return " AND ".join(sorted({entry["licence"] for entry in files}))


def _texts(data: Any) -> Iterator[str]:
    """Yield all texts of plain data; keys, too, since mixtures name objects as keys of their fractions."""
    if isinstance(data, dict):
        for key, value in data.items():
            yield from _texts(key)
            yield from _texts(value)
    elif isinstance(data, list):
        for value in data:
            yield from _texts(value)
    elif isinstance(data, str):
        yield data
