"""Where the data folders (scenes, assets, models, benchmarks) live: in the wheel or beside the package."""

import os
from importlib.util import find_spec
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


def texture_folder(name: str) -> Path:
    """Return the folder of a texture set: a shipped one by its name, or "package:folder" in an installed package.

    Raises:
        WarehouseSimError: The package is not installed.
    """
    package, is_package, folder = name.partition(":")
    if not is_package:
        return data_folder("assets") / "textures" / name
    spec = find_spec(package.split(".")[0]) and find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        raise WarehouseSimError(f"texture {name!r}: there is no package {package!r}; install what brings it")
    return Path(spec.submodule_search_locations[0]) / folder


def recipe_names() -> list[str]:
    """Return the names of the shipped recipes, sorted."""
    return sorted(path.stem for path in data_folder("scenes").glob("*.yaml"))


def find_recipe(name_or_path: str) -> Path:
    """Return the file of a recipe given by shipped name ("demo") or by path.

    Raises:
        UnknownNameError: Neither a shipped recipe nor a file.
    """
    path = Path(name_or_path)
    if path.suffix in (".yaml", ".yml") and os.path.isfile(path):
        return path
    shipped = data_folder("scenes") / f"{name_or_path}.yaml"
    if name_or_path in recipe_names() and shipped.is_file():
        return shipped
    raise UnknownNameError("recipe (a shipped name or the path of a .yaml file)", name_or_path, recipe_names())


def find_photometry(name_or_path: str) -> Path:
    """Return the photometric file of a luminaire given by shipped name ("aisle_narrow") or by path.

    Raises:
        UnknownNameError: Neither a shipped file nor one with the ending .ies.
    """
    path, shipped = Path(name_or_path), sorted((data_folder("scenes") / "photometry").glob("*.ies"))
    if path.suffix.lower() == ".ies" and os.path.isfile(path):
        return path
    for file in shipped:
        if file.stem == name_or_path:
            return file
    raise UnknownNameError(
        "photometry (a shipped name or the path of an .ies file)", name_or_path, [file.stem for file in shipped]
    )


def suite_names() -> list[str]:
    """Return the names of the shipped benchmark suites, sorted."""
    return sorted(path.stem for path in (data_folder("benchmarks") / "suites").glob("*.yaml"))


def model_names() -> list[str]:
    """Return the names of the bundled estimators, sorted."""
    return sorted(path.parent.name for path in data_folder("models").glob("*/config.yaml"))


def model_dir(name_or_path: str | Path) -> Path:
    """Return the folder of an estimator given by bundled name ("densefusion-pointcloud") or as a run folder.

    Raises:
        UnknownNameError: Neither a bundled name nor a folder.
    """
    path = Path(name_or_path)
    if path.is_dir():
        return path
    if str(name_or_path) in model_names():
        return data_folder("models") / str(name_or_path)
    raise UnknownNameError("estimator (a bundled name or a run folder)", str(name_or_path), model_names())


def cache_folder(name: str) -> Path:
    """Return the folder for what can be regenerated, such as "crops"; it may not exist yet.

    It is ``warehouse-sim/<name>`` in the user's cache folder (XDG base directory specification), or ``<name>`` in the
    folder that the environment variable ``WAREHOUSE_SIM_CACHE`` names.
    """
    if own := os.environ.get("WAREHOUSE_SIM_CACHE"):
        return Path(own) / name
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "warehouse-sim" / name
