"""Writes the pages that come from code and stored results into docs/generated, before Sphinx reads the sources."""

import contextlib
import io
import re
from pathlib import Path
from typing import Any

import warehouse_sim
from docs.site import recipe_reference, stored_results
from warehouse_sim.cli.commands import COMMANDS
from warehouse_sim.cli.main import main

ROOT = Path(__file__).resolve().parents[2]
GENERATED = ROOT / "docs" / "generated"
_FILE_NAME = re.compile(r"\[[\w/]+\.md\]\(")
_STORED = re.compile(r"\((?:\.\./)+benchmarks/results/(\w+)\.json\)")


def at_build_time(*_: Any) -> None:
    """Write all pages; those whose text is the same stay untouched, so that Sphinx builds only what changed."""
    wanted = {
        "recipe_reference.md": recipe_reference.page(),
        "api.md": api(),
        "command_reference.md": commands(),
        "faults.md": faults(),
    }
    wanted |= {f"results/{name}": text for name, text in stored_results.pages(ROOT / "benchmarks" / "results").items()}
    for path in GENERATED.rglob("*.md") if GENERATED.is_dir() else ():
        if str(path.relative_to(GENERATED)) not in wanted:
            path.unlink()
    for name, text in wanted.items():
        path = GENERATED / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def with_site_links(app: Any, page: str, source: list[str]) -> None:
    """Lead links to files of benchmarks/results to the pages that show them, and let titles stand for file names."""
    up = "../" * page.count("/")
    source[0] = _FILE_NAME.sub("[](", source[0])
    source[0] = _STORED.sub(rf"({up}docs/generated/results/\1.md)", source[0])


def api() -> str:
    """Return the reference of the public Python names."""
    parts = ["# Python reference\n\n[python.md](../python.md) shows how they go together.\n"]
    for name in warehouse_sim.__all__:
        if name.startswith("_"):
            continue
        thing = getattr(warehouse_sim, name)
        kind = "autoclass" if isinstance(thing, type) else "autofunction"
        members = "\n   :members:" if kind == "autoclass" else ""
        parts.append(f"## {name}\n\n```{{eval-rst}}\n.. {kind}:: warehouse_sim.{name}{members}\n```\n")
    return "\n".join(parts)


def commands() -> str:
    """Return the help page of every command."""
    parts = [
        "# Command reference\n\nThe pages of `warehouse-sim COMMAND --help`; [commands.md](../commands.md) is short.\n"
    ]
    for name in COMMANDS:
        text = io.StringIO()
        with contextlib.redirect_stdout(text), contextlib.suppress(SystemExit):
            main([name, "--help"])
        parts.append(f"## {name}\n\n```text\n{text.getvalue().strip()}\n```\n")
    return "\n".join(parts)


def faults() -> str:
    """Return the faults that ``validate`` is tested to find."""
    from tests.dataset.faults.table import FAULTS, THIRD_PARTY_FAULTS

    head = "| fault | check | message |\n|---|---|---|\n"
    rows = [
        [f"| {one.name} | {one.check} | ... {one.words} ... |" for one in part] for part in (FAULTS, THIRD_PARTY_FAULTS)
    ]
    return (
        "# Faults that validate finds\n\nA test plants each of these at a random place of a small rendered dataset and "
        "expects this check and message. *Everywhere* means that all tables agree on the wrong value, so that only "
        "pixels show it. [validate.md](../validate.md) explains the checks.\n\n"
        f"## In a dataset of this package\n\n{head}" + "\n".join(rows[0]) + "\n\n"
        "## In its BOP files alone, as in a third-party folder\n\n" + head + "\n".join(rows[1]) + "\n"
    )
