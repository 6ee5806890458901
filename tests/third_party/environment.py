"""An environment of its own, in which a stranger's package is installed as users install it, by pip."""

import json
import os
import subprocess
import sys
import sysconfig
import venv
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

SERVE = """
import contextlib, io, json, os, sys
from warehouse_sim.cli.main import main
for line in sys.stdin:
    folder, given = json.loads(line)
    os.chdir(folder)
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        code = main(given) if isinstance(given, list) else exec(given, {})
    print(json.dumps([code or 0, said.getvalue()]), flush=True)
"""


@dataclass(frozen=True)
class Session:
    """One process of an environment, which does one thing after another, as starting one takes seconds."""

    process: subprocess.Popen

    def command(self, *words: object, folder: Path, code: int = 0) -> str:
        """Run a command of ``warehouse-sim`` and return what it prints; its exit code must be ``code``."""
        return self._ask([str(item) for item in words], folder, code)

    def program(self, text: str, folder: Path) -> str:
        """Run a Python program and return what it prints."""
        return self._ask(text, folder, 0)

    def _ask(self, given: list[str] | str, folder: Path, code: int) -> str:
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(json.dumps([str(folder), given]) + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline()
        assert answer, f"it ended: {given}"
        found, said = json.loads(answer)
        assert found == code, said
        return said


@dataclass(frozen=True)
class Environment:
    """A virtual environment that sees everything that the one around it holds."""

    folder: Path

    @classmethod
    def create(cls, folder: Path) -> "Environment":
        """Make one without pip; what is installed into it stays in it."""
        venv.EnvBuilder(symlinks=True).create(folder)
        site = Path(sysconfig.get_path("purelib", vars={"base": str(folder), "platbase": str(folder)}))
        # A folder that is added as a site has its own .pth files read, by which the package itself is found.
        (site / "around.pth").write_text(f"import site; site.addsitedir({sysconfig.get_path('purelib')!r})\n")
        return cls(folder)

    @property
    def python(self) -> Path:
        """Its interpreter."""
        return self.folder / "bin" / "python"

    def pip(self, *arguments: str) -> None:
        """Run pip on it; nothing is fetched."""
        outcome = subprocess.run(
            [sys.executable, "-m", "pip", "--python", str(self.python), "--disable-pip-version-check", *arguments],
            capture_output=True,
            text=True,
        )
        assert outcome.returncode == 0, outcome.stdout + outcome.stderr

    def install(self, package: Path) -> None:
        """Install the package of a folder; what it is built with comes from the environment around."""
        self.pip("install", "--quiet", "--no-deps", "--no-index", "--no-build-isolation", str(package))

    def run_command(self, *words: str) -> str:
        """Run a command of ``warehouse-sim`` in a process of its own and return what it prints."""
        command = [str(self.python), "-m", "warehouse_sim", *words]
        outcome = subprocess.run(command, capture_output=True, text=True, env=_surroundings())
        assert outcome.returncode == 0, outcome.stdout[-4000:] + outcome.stderr[-4000:]
        return outcome.stdout

    @contextmanager
    def session(self) -> Iterator[Session]:
        """Start a process that does what it is told, until the block ends."""
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
        with subprocess.Popen([str(self.python), "-c", SERVE], text=True, env=_surroundings(), **pipes) as process:
            yield Session(process)


def _surroundings() -> dict[str, str]:
    return os.environ | {"OMP_NUM_THREADS": "1", "COLUMNS": "200"}
