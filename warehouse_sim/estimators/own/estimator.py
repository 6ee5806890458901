"""A user's own estimator: an object or a function is called for each image, and what it returns is checked."""

import inspect
import sysconfig
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.results.pose_csv import require_estimates
from warehouse_sim.errors import EstimatorError, InputError, shown
from warehouse_sim.estimators.api import KnownObject, LeastVisible, PoseEstimator
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.settings import DepthSource
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.schema import PoseEstimate

_PACKAGE_FOLDER = Path(__file__).resolve().parents[2]
_INSTALLED = tuple(Path(sysconfig.get_path(name)) for name in ("stdlib", "platstdlib", "purelib", "platlib"))
_LONGEST = 300
"""Characters of an error's text in one line."""


def own_traceback(problem: BaseException) -> str:
    """Return the traceback of an error as text, without the frames of this package and of installed ones."""
    frames = [
        frame for frame in traceback.extract_tb(problem.__traceback__) if not _is_in(frame.filename, _PACKAGE_FOLDER)
    ]
    own = [frame for frame in frames if not any(_is_in(frame.filename, folder) for folder in _INSTALLED)]
    lines = traceback.format_list(own or frames)
    head = ["Traceback (most recent call last):\n"] if lines else []
    return "".join([*head, *lines, *traceback.format_exception_only(problem)]).rstrip("\n")


def summary_of(problem: BaseException) -> str:
    """Return the class and text of an error in one line."""
    text = " ".join(str(problem).split())
    short = text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."
    return f"{type(problem).__name__}: {short}" if short else type(problem).__name__


def _is_in(filename: str, folder: Path) -> bool:
    return filename.startswith("<frozen") or Path(filename).resolve().is_relative_to(folder.resolve())


_OPTIONAL = ("reads_rgb", "reads_depth", "reads_sweep", "finds_objects", "depth_source", "min_visible", "surfaces")
"""Attributes that an estimator may have; those of ``OwnEstimator`` hold where it has none."""
_PACKAGE = __name__.partition(".")[0]


class NamedObject(NamedTuple):
    """An object that a user's estimator knows."""

    obj_id: int
    name: str
    class_name: str = ""


class OwnEstimator(PoseEstimator):
    """Calls a user's estimator, and says which image it was called with when it fails.

    Args:
        name: How messages call it.
        inner: An object with ``estimate(image)``, or a function that takes an image.
    """

    learns_objects = True
    reads_rgb: bool = True
    reads_depth: bool = False
    reads_sweep: bool = False
    finds_objects: bool = False
    depth_source: DepthSource | None = None
    min_visible: LeastVisible = LeastVisible()
    surfaces: Mapping[int, TriangleMesh] = MappingProxyType({})

    def __init__(self, name: str, inner: Any) -> None:
        self.__name__, self._inner = name, inner
        self._estimate: Callable[[RgbdImage], Any] = getattr(inner, "estimate", inner)
        _require_one_argument(name, self._estimate)
        for attribute in _OPTIONAL:
            setattr(self, attribute, getattr(inner, attribute, getattr(type(self), attribute)))

    @property
    def objects(self) -> Sequence[KnownObject] | None:
        """What it knows; None, any object, where it does not say.

        Raises:
            InputError: Its ``objects`` have no ``obj_id`` and ``name``.
        """
        known = getattr(self._inner, "objects", None)
        if known is None:
            return None
        if not isinstance(known, Sequence) or not all(hasattr(i, "obj_id") and hasattr(i, "name") for i in known):
            raise InputError(
                f"estimator {self.__name__}: objects must be None or a list of objects with obj_id and name, "
                f"found {shown(known)}"
            )
        return [NamedObject(item.obj_id, item.name, getattr(item, "class_name", "")) for item in known]

    def onboard(self, objects: Mapping[int, ObjectInfo]) -> None:
        """Show it the objects of a dataset, by obj_id, if it takes them."""
        if hasattr(self._inner, "onboard"):
            with errors_of(self.__name__, "when it was shown the objects of the dataset"):
                self._inner.onboard(objects)

    def estimate(self, image: RgbdImage) -> list[PoseEstimate]:
        """Return what it returns for an image.

        Raises:
            EstimatorError: It fails.
            InputError: It returns something else than estimates of this image.
        """
        place = f"on scene {image.scene_id}, image {image.image_id}"
        with errors_of(self.__name__, place):
            found = self._estimate(image)
            if isinstance(found, Iterator):  # a generator's code runs only now
                found = list(found)
        where = f"estimator {self.__name__} {place}: what it returns"
        estimates = require_estimates(found, where)
        for number, item in enumerate(estimates):
            if (item.scene_id, item.image_id) != (image.scene_id, image.image_id):
                raise InputError(
                    f"{where}: estimate {number} is of scene {item.scene_id}, image {item.image_id}; "
                    "take image.scene_id and image.image_id"
                )
        return estimates


def own_estimator(estimator: Any, name: str | None = None) -> PoseEstimator:
    """Return an estimator of this package as it is, and any other object, class or function as one.

    Args:
        estimator: An object with ``estimate(image)``, a class of such that takes no arguments, or a function that takes
            an ``RgbdImage`` and returns a list of ``PoseEstimate``.
        name: How messages call it; by default its own name.

    Raises:
        InputError: It is none of these.
        EstimatorError: The class cannot be called.
    """
    called = name or str(getattr(estimator, "__qualname__", type(estimator).__qualname__))
    if isinstance(estimator, type):
        estimator = _made(called, estimator)
    if isinstance(estimator, PoseEstimator):
        return estimator
    if callable(getattr(estimator, "estimate", None)) or callable(estimator):
        return OwnEstimator(called, estimator)
    raise InputError(
        "an estimator is a name, a run folder, an object with estimate(image) or a function of an image, "
        f"found {name or shown(estimator)}"
    )


@contextmanager
def errors_of(name: str, place: str) -> Iterator[None]:
    """Turn any error of a user's code into one that names the estimator and holds the user's part of the traceback."""
    try:
        yield
    except (Exception, SystemExit) as problem:  # a class that ends the program would do so without a word
        message = f"estimator {name} failed {place}: {summary_of(problem)}"
        raise EstimatorError(message, own_traceback(problem)) from problem


def _made(name: str, cls: type) -> Any:
    try:
        inspect.signature(cls).bind()
    except TypeError as problem:
        raise InputError(
            f"estimator {name}: the class is called without arguments, but {problem}; give them defaults"
        ) from None
    except ValueError:  # a class without a signature
        pass
    with errors_of(name, "when it was made"):
        return cls()


def _require_one_argument(name: str, function: Callable[..., Any]) -> None:
    try:
        signature = inspect.signature(function)
    except ValueError:  # a function of C has none
        return
    try:
        signature.bind(None)
    except TypeError as problem:
        raise InputError(f"estimator {name} is called with the image alone, but {problem}") from None
