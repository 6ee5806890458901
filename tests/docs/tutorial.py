"""Runs the code of a page in order: shell lines as commands, Python as one program, YAML as the files that it names."""

import re
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from warehouse_sim.cli.main import main

_BLOCK = re.compile(r"^```(\w+)(?: (\w+))?\n(.*?)^```", re.MULTILINE | re.DOTALL)
_FILE = re.compile(r"# (\w+\.(?:py|yaml))\n")
RUN = ("sh", "python", "yaml")
"""Languages of code; ``text`` is what no test runs."""


def blocks(page: Path) -> list[tuple[str, str, str]]:
    """Return language, condition (a package such as ray, mostly empty) and text of each block of code."""
    found = _BLOCK.findall(page.read_text(encoding="utf-8"))
    return [(language, needs, text) for language, needs, text in found if language in RUN]


def run(page: Path, small: Mapping[str, str], only: str = "") -> None:
    """Run a page in the working directory.

    Args:
        page: A Markdown file.
        small: What stands in for what would take long.
        only: Condition of the blocks that run.
    """
    names: dict[str, Any] = {}
    for language, needs, written in blocks(page):
        if needs != only:
            continue
        text = written
        for long, short in small.items():
            text = text.replace(long, short)
        file = _FILE.match(text)
        if file:
            Path(file.group(1)).write_text(text, encoding="utf-8")
        elif language == "python":
            exec(compile(text, page.name, "exec"), names)
        elif language == "sh":
            for line in text.splitlines():
                program, *arguments = shlex.split(line)
                assert program == "warehouse-sim", f"{page.name}: {line}"
                assert main(arguments) == 0, f"{page.name}: {line}"
        else:
            raise AssertionError(f"{page.name}: a block of {language} names no file:\n{text}")
