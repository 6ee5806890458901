"""Open a user's own estimator by ``path/file.py:Class`` or ``module:Class``."""

import importlib
import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

from warehouse_sim.errors import EstimatorError, InputError, UnknownNameError
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.own.estimator import own_estimator, own_traceback, summary_of

_PREFIX = "warehouse_sim_own_"
"""Of the names of modules that are opened as files."""


def is_own_source(name: str) -> bool:
    """Return whether a name is written as ``file.py:Class``, ``module:Class`` or ``file.py``."""
    source, colon, attribute = name.rpartition(":")
    return name.endswith((".py", ".py:")) or bool(colon and source and attribute)


def source_file(name: str) -> Path | None:
    """Return the file that holds what ``file.py:Class`` or ``module:Class`` names; None where it is not found."""
    source = name.rpartition(":")[0]
    if source.endswith(".py"):
        return Path(source) if Path(source).is_file() else None
    _search_in(Path.cwd())
    try:
        spec = importlib.util.find_spec(source)
    except (ImportError, ValueError):
        return None
    origin = None if spec is None or spec.origin is None else Path(spec.origin)
    return origin if origin is not None and origin.is_file() else None


def open_source(name: str) -> PoseEstimator:
    """Return the estimator that ``file.py:Class`` or ``module:Class`` names; a function or an object does, too.

    Raises:
        InputError: The file or module does not exist, cannot be imported, or the class needs arguments.
        UnknownNameError: The file has no such class.
        EstimatorError: The class or the file raises an error.
    """
    source, _, attribute = name.rpartition(":") if ":" in name else (name, "", "")
    path = Path(source)
    module = _from_file(path) if path.suffix == ".py" else _from_module(source)
    shown = path.name if path.suffix == ".py" else source
    known = _names(module)
    if not attribute:
        raise InputError(f"{name}: name the class or function in it, as {shown}:{known[0] if known else 'Class'}")
    found = getattr(module, attribute, None)
    if found is None:
        raise UnknownNameError(f"class or function of {shown}", attribute, known)
    return own_estimator(found, f"{shown}:{attribute}")


def _from_file(path: Path) -> ModuleType:
    if not path.is_file():
        raise InputError(f"{path}: there is no such file; name an existing one, as path/file.py:Class")
    _search_in(path.resolve().parent)
    key = f"{_PREFIX}{path.stem}"
    spec = importlib.util.spec_from_file_location(key, path.resolve())
    assert spec is not None  # any .py file has one, with a loader
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[key] = module
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as problem:
        del sys.modules[key]
        raise _import_error(str(path), problem) from problem
    return module


def _from_module(source: str) -> ModuleType:
    _search_in(Path.cwd())
    try:
        return importlib.import_module(source)
    except ModuleNotFoundError as problem:
        if problem.name is None or not f"{source}.".startswith(f"{problem.name}."):
            raise _import_error(source, problem) from problem
        raise InputError(
            f"{source}: there is no such module here or among the installed packages; "
            "correct its name, or name a file as path/file.py:Class"
        ) from None
    except (Exception, SystemExit) as problem:
        raise _import_error(source, problem) from problem


def _import_error(source: str, problem: BaseException) -> InputError:
    if isinstance(problem, SyntaxError):
        return InputError(f"{source}: line {problem.lineno} is not Python: {problem.msg}; correct it")
    if isinstance(problem, ImportError):
        return InputError(f"{source}: cannot be imported: {problem}; install what is missing or correct the import")
    return EstimatorError(f"{source}: cannot be imported: {summary_of(problem)}", own_traceback(problem))


def _search_in(folder: Path) -> None:
    """Let imports find the modules beside a file, as Python does for a script."""
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))


def _names(module: ModuleType) -> list[str]:
    def is_own(item: Any) -> bool:
        return callable(item) and getattr(item, "__module__", "") == module.__name__

    return [name for name, item in vars(module).items() if not name.startswith("_") and is_own(item)]
