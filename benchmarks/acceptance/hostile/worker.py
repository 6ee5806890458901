"""One process that runs command lines of ``warehouse-sim`` one after the other, as a terminal would see them.

    python -m benchmarks.acceptance.hostile.worker MODULE:FUNCTION

It reads one JSON object a line from stdin, ``{"argv": [...], "folder": DIR, "out": FILE, "err": FILE}``, works in that
folder with both streams, those of C libraries included, in these files, and answers with one line, ``{"code": N}``.
"""

import ctypes
import importlib
import io
import json
import os
import signal
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

_DIE_WITH_PARENT = 1
"""PR_SET_PDEATHSIG of Linux's prctl."""


def serve(command: Callable[[list[str]], Any]) -> None:
    """Run ``command`` on every command line that stdin brings, until it closes or the parent is gone."""
    ctypes.CDLL(None).prctl(_DIE_WITH_PARENT, signal.SIGKILL)
    requests = os.fdopen(os.dup(0), encoding="utf-8")
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    for line in requests:
        request = json.loads(line)
        os.chdir(request["folder"])
        with _streams_into(Path(request["out"]), Path(request["err"])):
            code = _exit_code(command, request["argv"])
        answers.write(json.dumps({"code": code}) + "\n")
        answers.flush()


def _exit_code(command: Callable[[list[str]], Any], argv: list[str]) -> int:
    """Return what Python's interpreter would exit with, and print what it would print."""
    try:
        return int(command(argv) or 0)
    except SystemExit as leaving:
        if leaving.code is None or isinstance(leaving.code, int):
            return leaving.code or 0
        print(leaving.code, file=sys.stderr)
    except BaseException:
        traceback.print_exc()
    return 1


@contextmanager
def _streams_into(out: Path, err: Path) -> Iterator[None]:
    """Send both streams, also what C libraries write, into files, and each line at once: a crash loses none."""
    kept = [os.dup(1), os.dup(2)]
    for number, path in ((1, out), (2, err)):
        file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        os.dup2(file, number)
        os.close(file)
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = (
        io.TextIOWrapper(io.FileIO(number, "w", closefd=False), encoding="utf-8", write_through=True)
        for number in (1, 2)
    )
    try:
        yield
    finally:
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        sys.stdout, sys.stderr = before
        for number, copy in zip((1, 2), kept, strict=True):
            os.dup2(copy, number)
            os.close(copy)


if __name__ == "__main__":
    module, _, function = sys.argv[1].partition(":")
    serve(getattr(importlib.import_module(module), function))
