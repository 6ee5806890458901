"""A Dockerfile's instructions, run without a container: in folders and empty environments of Python."""

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

_PLACES = re.compile(r"(?<![\w.-])/(source|wheels|locks)\b")
_APT = re.compile(r"apt-get install ([^&]*)")


@dataclass(frozen=True)
class Stage:
    """What ``FROM`` begins: a folder in place of the image's root, with an environment of its own."""

    root: Path

    def environment(self, arguments: dict[str, str]) -> dict[str, str]:
        """Return the variables of a shell in it; this checkout and its packages are not in reach."""
        kept = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "VIRTUAL_ENV"))}
        return {**kept, **arguments, "PATH": f"{self.root / 'venv' / 'bin'}:/usr/bin:/bin"}


def instructions(path: Path) -> list[tuple[str, str]]:
    """Return word and rest of each instruction."""
    lines = path.read_text(encoding="utf-8").replace("\\\n", " ").splitlines()
    split = [line.split(None, 1) for line in lines if line.strip() and not line.startswith("#")]
    return [(word, rest) for word, rest in split]


def build(checkout: Path, folder: Path, given: dict[str, str]) -> Stage:
    """Run the instructions of ``checkout``'s Dockerfile, and return the last stage.

    System packages are only looked up (``apt-get --simulate``); of the base image, user and entry point nothing is run.

    Args:
        checkout: Holds the Dockerfile and its context.
        folder: Where the stages' folders come.
        given: Arguments of the build.
    """
    stages: dict[str, Stage] = {}
    arguments: dict[str, str] = {}
    stage = Stage(folder)
    for word, rest in instructions(checkout / "Dockerfile"):
        if word == "FROM":
            name = rest.rpartition(" AS ")[2] if " AS " in rest else "last"
            stage = stages[name] = Stage(folder / name)
            stage.root.mkdir()
            subprocess.run([sys.executable, "-m", "venv", str(stage.root / "venv")], check=True)
        elif word == "ARG":
            name, _, default = rest.partition("=")
            arguments[name] = given.get(name, default)
        elif word == "COPY":
            _copy(rest, checkout, stages, stage)
        elif word == "RUN":
            _run(rest, stage, arguments)
    return stage


def _copy(rest: str, checkout: Path, stages: dict[str, Stage], stage: Stage) -> None:
    *options, source, target = rest.split()
    other = [option.removeprefix("--from=") for option in options]
    to = stage.root / target.lstrip("/")
    if other:
        shutil.copytree(stages[other[0]].root / source.lstrip("/"), to)
    elif source == ".":
        for path in context(checkout):
            (to / path.relative_to(checkout)).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, to / path.relative_to(checkout))
    else:
        shutil.copytree(checkout / source, to)


def context(checkout: Path) -> list[Path]:
    """Return the files that ``.dockerignore`` leaves: it excludes all, and takes some back."""
    lines = (checkout / ".dockerignore").read_text(encoding="utf-8").splitlines()
    kept = [checkout / line[1:] for line in lines if line.startswith("!")]
    assert "*" in lines
    files = [path for item in kept for path in ([item] if item.is_file() else item.rglob("*")) if path.is_file()]
    return [path for path in files if "__pycache__" not in path.parts]


def _run(line: str, stage: Stage, arguments: dict[str, str]) -> None:
    if found := _APT.search(line):
        command = f"apt-get install --simulate {found.group(1)}"
    else:
        command = _PLACES.sub(lambda place: str(stage.root / place.group(1)), line)
    done = subprocess.run(
        ["sh", "-c", command], env=stage.environment(arguments), cwd="/", capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"RUN {line}\n{done.stdout[-1000:]}\n{done.stderr[-2000:]}"
