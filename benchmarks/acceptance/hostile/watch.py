"""Run command lines in a worker process under a limit of time and one of memory; what dies or sleeps is replaced."""

import json
import os
import select
import signal
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Self

_CHECKOUT = Path(__file__).parents[3]
_LOOK_EVERY = 0.2
# Contexts of OpenGL that come and go are what drivers leak; a worker is not to die of the cases before.
_CASES_A_WORKER = 60
_PAGE, _TICKS = os.sysconf("SC_PAGE_SIZE"), os.sysconf("SC_CLK_TCK")
_WALL = 8.0


@dataclass(frozen=True)
class Limits:
    """When a command line is given up."""

    seconds: float = 30.0
    """Processor time of one command line (s), and an eighth of the wall time that it gets: others may be at work."""
    memory: float = 6.0
    """Resident memory of the process and its children (GiB)."""


@dataclass(frozen=True)
class Outcome:
    """What a command line did."""

    argv: tuple[str, ...]
    code: int | None
    """Exit code; none where the process died or was stopped."""
    out: str
    err: str
    seconds: float
    death: str = ""
    """Why there is no exit code: "hang", "memory" or the name of a signal."""


class Watched:
    """A worker process and the rule by which it is stopped.

    Args:
        command: ``module:function`` that takes a command line and returns an exit code.
        limits: When a command line is given up.
        scratch: Folder for the streams of the worker.
    """

    def __init__(self, command: str, limits: Limits, scratch: Path) -> None:
        self._command, self._limits, self._scratch = command, limits, scratch
        self._process: subprocess.Popen[str] | None = None
        self._served = 0

    def __enter__(self) -> Self:
        self._scratch.mkdir(parents=True, exist_ok=True)
        return self

    def __exit__(self, *_: object) -> None:
        self.renew()

    def renew(self) -> None:
        """End the worker and all that it has started; the next command line gets a new one."""
        process, self._process = self._process, None
        if process is None:
            return
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        for stream in (process.stdin, process.stdout):
            if stream is not None:
                with suppress(BrokenPipeError):
                    stream.close()

    def run(self, argv: tuple[str, ...], folder: Path, seconds: float | None = None) -> Outcome:
        """Run one command line in ``folder``, for ``seconds`` of processor time, by default as the limits say."""
        out, err = self._scratch / "out.txt", self._scratch / "err.txt"
        for path in (out, err):
            path.unlink(missing_ok=True)
        process = self._ready()
        start = time.monotonic()
        request = {"argv": list(argv), "folder": str(folder), "out": str(out), "err": str(err)}
        assert process.stdin is not None
        process.stdin.write(json.dumps(request) + "\n")
        process.stdin.flush()
        code, death = self._wait(process, seconds or self._limits.seconds)
        self._served += 1
        streams = [path.read_text(encoding="utf-8", errors="replace") if path.is_file() else "" for path in (out, err)]
        return Outcome(argv, code, *streams, time.monotonic() - start, death)

    def _ready(self) -> "subprocess.Popen[str]":
        """Return a living worker; a new one after enough cases."""
        if self._process is not None and (self._process.poll() is not None or self._served >= _CASES_A_WORKER):
            self.renew()
        if self._process is None:
            self._served = 0
            self._process = subprocess.Popen(
                [sys.executable, "-m", f"{__package__}.worker", self._command],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                text=True,
                start_new_session=True,
                cwd=_CHECKOUT,
            )
        return self._process

    def _wait(self, process: "subprocess.Popen[str]", seconds: float) -> tuple[int | None, str]:
        assert process.stdout is not None
        deadline, busy = time.monotonic() + _WALL * seconds, _busy(process.pid) + seconds
        while True:
            if select.select([process.stdout], [], [], _LOOK_EVERY)[0]:
                answer = process.stdout.readline()
                if answer:
                    return json.loads(answer)["code"], ""
                number = -process.wait()
                self.renew()
                return None, signal.Signals(number).name if number > 0 else f"exit {-number} from within"
            if time.monotonic() > deadline or _busy(process.pid) > busy:
                self.renew()
                return None, "hang"
            if _resident(process.pid) > self._limits.memory:
                self.renew()
                return None, "memory"


def _busy(pid: int) -> float:
    """Return the processor time of a process and of those of its children that have ended (s)."""
    try:
        words = Path(f"/proc/{pid}/stat").read_text(encoding="ascii", errors="replace").rpartition(")")[2].split()
    except OSError:
        return 0.0
    return sum(map(int, words[11:15])) / _TICKS


def _resident(pid: int) -> float:
    """Return the resident memory of a process and its children (GiB)."""
    total, waiting = 0.0, [pid]
    while waiting:
        folder = Path(f"/proc/{waiting.pop()}")
        try:
            total += int((folder / "statm").read_text().split()[1]) * _PAGE / 2**30
            waiting += map(int, (folder / "task" / folder.name / "children").read_text().split())
        except (OSError, ValueError):
            continue
    return total
