"""An environment of its own, in which a stranger's package is installed as users install it, by pip."""

import json
import os
import subprocess
import sys
import sysconfig
import venv
from dataclasses import dataclass
from pathlib import Path

COMMANDS = """
import contextlib, io, json, sys
from warehouse_sim.cli.main import main
outcomes = []
for command in json.loads(sys.argv[1]):
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        code = main(command)
    outcomes.append((code, said.getvalue()))
print(json.dumps(outcomes))
"""


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

    def run_command(self, *arguments: object, folder: Path | None = None, code: int = 0) -> str:
        """Run a command of ``warehouse-sim`` and return what it prints; its exit code must be ``code``."""
        return self._run(("-m", "warehouse_sim", *map(str, arguments)), folder, code)

    def run_commands(self, *commands: tuple[object, ...], folder: Path | None = None, code: int = 0) -> list[str]:
        """Run commands one after another in one process, as starting one takes seconds; return what each prints.

        Each must end with the exit code ``code``.
        """
        given = json.dumps([[str(item) for item in command] for command in commands])
        outcomes = json.loads(self._run(("-c", COMMANDS, given), folder, 0).splitlines()[-1])
        assert [found for found, _ in outcomes] == [code] * len(commands), outcomes
        return [said for _, said in outcomes]

    def script(self, text: str, folder: Path | None = None) -> str:
        """Run a Python program and return what it prints."""
        return self._run(("-c", text), folder, 0)

    def _run(self, command: tuple[str, ...], folder: Path | None, code: int) -> str:
        outcome = subprocess.run(
            [str(self.python), *command],
            capture_output=True,
            text=True,
            cwd=folder,
            env=os.environ | {"OMP_NUM_THREADS": "1", "COLUMNS": "200"},
        )
        assert outcome.returncode == code, outcome.stdout[-4000:] + outcome.stderr[-4000:]
        return outcome.stdout
