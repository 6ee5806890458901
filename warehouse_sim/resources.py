"""Where the data folders (scenes, assets, models, benchmarks) live: in the wheel or beside the package."""

from pathlib import Path

from warehouse_sim.errors import UnknownNameError, WarehouseSimError

_PACKAGE = Path(__file__).resolve().parent


def data_folder(name: str) -> Path:
    """Return the folder of shipped data called ``name`` ("scenes", "assets", "models", "benchmarks").

    Raises:
        WarehouseSimError: The installation lacks the folder.
    """
    for candidate in (_PACKAGE / "_data" / name, _PACKAGE.parent / name):
        if candidate.is_dir():
            return candidate
    raise WarehouseSimError(f"the data folder {name!r} is missing from this installation; reinstall warehouse-sim")


def recipe_names() -> list[str]:
    """Return the names of the shipped recipes, sorted."""
    return sorted(path.stem for path in data_folder("scenes").glob("*.yaml"))


def find_recipe(name_or_path: str) -> Path:
    """Return the file of a recipe given by shipped name ("demo") or by path.

    Raises:
        UnknownNameError: Neither a shipped recipe nor a file.
    """
    path = Path(name_or_path)
    if path.suffix in (".yaml", ".yml") and path.is_file():
        return path
    shipped = data_folder("scenes") / f"{name_or_path}.yaml"
    if name_or_path in recipe_names() and shipped.is_file():
        return shipped
    raise UnknownNameError("recipe (a shipped name or the path of a .yaml file)", name_or_path, recipe_names())


def suite_names() -> list[str]:
    """Return the names of the shipped benchmark suites, sorted."""
    return sorted(path.stem for path in (data_folder("benchmarks") / "suites").glob("*.yaml"))
