"""One family of errors: each says what, where and what to do, in one line."""

import difflib
import os
from collections.abc import Iterable, Sequence
from typing import Any

_LONGEST = 80
"""Characters of a value that a message quotes."""
_MOST_NAMES, _NEAREST = 32, 6
"""Names that a message lists all, and how many of those most like what was written where there are more."""


def shown(value: Any) -> str:
    """Return a value as a message quotes it: on one line, and without its middle where it is long."""
    text = " ".join(line.strip() for line in repr(value).splitlines())
    if len(text) <= _LONGEST:
        return text
    half = (_LONGEST - 3) // 2  # the end, too, tells what it is: that of a path is its name
    return f"{text[:half]}...{text[-half:]}"


class WarehouseSimError(Exception):
    """Base of every error that a user of this package can cause or meet.

    Example:
        >>> try:
        ...     ws.Dataset("nowhere")
        ... except ws.WarehouseSimError as problem:
        ...     print(problem)
        nowhere: is not a folder; name the folder of a dataset, or generate one
    """

    scenes: tuple[int, ...] = ()
    """The scenes of a dataset that could not be made, where that is what happened."""


class ConfigError(WarehouseSimError):
    """A configuration or recipe holds a key or value that cannot be used."""


class RecipeError(ConfigError):
    """A scene recipe cannot be read."""


class UnknownNameError(WarehouseSimError):
    """A name is not registered; the message lists the known ones, or those most like it where they are many."""

    def __init__(self, kind: str, name: str, known: list[str]) -> None:
        # Who writes a path must not search among names.
        missing = " (there is no such file)" if "/" in name and not os.path.exists(name) else suggestion(name, known)
        super().__init__(f"unknown {kind} {shown(name)}{missing}; known: {_listed(name, sorted(known)) or '(none)'}")
        self.kind, self.name, self.known = kind, name, sorted(known)

    def __reduce__(self) -> tuple[type, tuple[str, str, list[str]]]:
        """Pickle by the arguments, so that the error crosses from a worker process."""
        return type(self), (self.kind, self.name, self.known)


def nearest(name: str, known: Sequence[str]) -> list[str]:
    """Return the known name that is most like another one, the first by the alphabet of several; none if none is.

    Capitals count for nothing, and "-" and " " are "_": OS1-64 is os1_64.
    """
    meant, plain = _plain(str(name)[:_LONGEST]), {_plain(item): item for item in known}
    found = difflib.get_close_matches(meant, plain, 6)
    ratio = {item: difflib.SequenceMatcher(None, item, meant).ratio() for item in found}
    best = [plain[item] for item in found if ratio[item] == max(ratio.values())]
    return [min(best)] if best else []


def _plain(name: str) -> str:
    return name.lower().replace("-", "_").replace(" ", "_")


def suggestion(name: Any, known: Iterable[str]) -> str:
    """Return " (did you mean 'demo'?)" with the known name that is most like another one; nothing if none is."""
    near = nearest(str(name), list(known))
    return f" (did you mean {near[0]!r}?)" if near else ""


def not_listed(where: str, value: Any, known: Sequence[Any]) -> str:
    """Return that a setting must be one of some values, and which name was perhaps meant."""
    names = [item for item in known if isinstance(item, str)]
    return f"{where} must be one of {', '.join(map(repr, known))}, found {shown(value)}{suggestion(value, names)}"


def _listed(name: str, known: Sequence[str]) -> str:
    if len(known) <= _MOST_NAMES:
        return ", ".join(known)
    near = difflib.get_close_matches(str(name)[:_LONGEST], known, _NEAREST, cutoff=0.0)
    return f"{', '.join(near)} and {len(known) - len(near)} more"


class MissingPackageError(WarehouseSimError):
    """An optional package or system library is not installed."""


class PlacementError(WarehouseSimError):
    """Objects requested do not fit where the recipe wants them."""


class SettleError(WarehouseSimError):
    """A scene did not come to rest, or came to rest in an impossible state."""


class WorkerError(WarehouseSimError):
    """A process that made a scene was ended from outside or crashed, and so was the one that made it again."""


class RenderError(WarehouseSimError):
    """No renderer could be opened, or a frame could not be drawn."""


class DatasetError(WarehouseSimError):
    """A dataset on disk is incomplete, inconsistent or cannot hold what was requested."""


class OutputError(WarehouseSimError):
    """A file or folder cannot be written."""


class TrainingError(WarehouseSimError):
    """A run folder or its data cannot be used for training or prediction."""


class InputError(WarehouseSimError):
    """Images, masks and a camera that were given to an estimator do not fit together."""


class EstimatorError(InputError):
    """A user's own estimator raised an error."""

    def __init__(self, message: str, details: str = "") -> None:
        super().__init__(message)
        self.details = details
        """The traceback, the user's frames alone, which the command line prints above the message."""


class OutOfRangeError(DatasetError, IndexError):
    """A dataset has no observation of that number; loops that count up end at it."""


class EvaluationError(WarehouseSimError):
    """Predictions cannot be scored against the dataset."""
