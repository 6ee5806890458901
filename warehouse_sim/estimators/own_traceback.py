"""The part of a traceback that is a user's own code."""

import sysconfig
import traceback
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]
_INSTALLED = tuple(Path(sysconfig.get_path(name)) for name in ("stdlib", "platstdlib", "purelib", "platlib"))
_LONGEST = 300
"""Characters of an error's text in one line."""


def own_traceback(problem: BaseException) -> str:
    """Return the traceback of an error as text, without the frames of this package and of installed ones."""
    frames = [frame for frame in traceback.extract_tb(problem.__traceback__) if not _is_in(frame.filename, _PACKAGE)]
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
