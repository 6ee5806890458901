"""Help pages: the groups of commands, and the options of one command with plain placeholders."""

import argparse
import re
import shutil
import textwrap
from collections.abc import Collection

from warehouse_sim.cli.commands import COMMANDS, GROUPS, Command
from warehouse_sim.version import __version__

_PLACES = {
    "recipe": "RECIPE",
    "data": "DIR",
    "run": "ESTIMATOR",
    "estimator": "NAME",
    "estimators": "NAME",
    "detector": "NAME",
    "detections": "NAME",
    "suite": "SUITE",
    "formats": "FORMAT",
    "to": "FORMAT",
    "backend": "NAME",
    "backend-options": "KEY=VALUE",
    "shard": "I/N",
    "predictions": "CSV",
    "folders": "DIR",
    "merge": "DIR",
    "labels": "DIR",
    "pictures": "DIR",
    "cache": "DIR",
    "save": "FILE",
    "json": "FILE",
    "sheet": "FILE",
    "init": "NAME",
    "kind": "KIND",
    "objects": "OBJECT",
    "split": "{train,val,test,all}",
    "splits": "{train,val,test}",
    "exec": "COMMAND",
    "carriage": "ID[:FACE]",
}
"""Placeholders by the name of the argument."""
_TYPES = {"INT": "N", "FLOAT": "X", "STR": "NAME", "PATH": "PATH"}


def overview() -> str:
    """Return the page of all commands."""
    lines = [
        "warehouse-sim: generate synthetic warehouse datasets, and benchmark 6D-pose estimators on them.",
        "",
        "usage: warehouse-sim COMMAND [OPTIONS]      warehouse-sim COMMAND --help",
    ]
    for group, title in GROUPS.items():
        lines += ["", f"{title}:"]
        lines += [f"  {item.name:13} {item.summary}" for item in COMMANDS.values() if item.group == group]
    return "\n".join([*lines, "", f"version {__version__}; `warehouse-sim list` names recipes, sensors and estimators"])


def page(command: Command, parser: argparse.ArgumentParser, whole: bool) -> str:
    """Return the page of one command.

    Args:
        command: Which one.
        parser: What parses it.
        whole: Whether settings of parts, such as ``--tracking.drift``, get a line each; else each part gets one line.
    """
    width = min(shutil.get_terminal_size((100, 24)).columns, 110)
    actions = [action for action in parser._actions if action.dest != "help"]
    positional = [action for action in actions if not action.option_strings]
    options = [action for action in actions if action.option_strings]
    names = {name for action in options for name in action.option_strings}
    required = [f"{action.option_strings[0]} {placeholder(action, command)}" for action in options if action.required]
    usage = " ".join(["warehouse-sim", command.name, *(_in_usage(item, command) for item in positional), *required])
    text = re.sub(r"``", "", parser.description or command.summary)
    lines = [f"usage: {usage} [OPTIONS]", "", *_paragraphs(text, width)]
    if positional:
        lines += ["", "arguments:"]
        for action in positional:
            lines += _row(placeholder(action, command), _text(action, names), width)
    shown = [action for action in options if whole or "." not in action.option_strings[0]]
    lines += ["", "options:"]
    for action in shown:
        lines += _row(_flag(action, command), _text(action, names), width)
    lines += _row("--help, --help-all", "Show this page; with the settings of all parts.", width)
    if folded := {action.option_strings[0].split(".")[0] for action in options if action not in shown}:
        lines += ["", "settings of parts, listed by --help-all:"]
        for part in sorted(folded):
            inner = [action.option_strings[0].split(".", 1)[1] for action in options if _is_of(action, part)]
            lines += _row(f"{part}.*", ", ".join(inner), width)
    return "\n".join([*lines, "", "examples:", *(f"  warehouse-sim {example}" for example in command.examples)])


def placeholder(action: argparse.Action, command: Command) -> str:
    """Return what stands for the value of an argument: ``RECIPE``, ``N``, ``{a,b}``."""
    name = action.dest.split(".")[-1].replace("_", "-")
    if name == "out":
        return command.outputs
    if action.choices is not None:
        found = "{" + ",".join(sorted(str(choice) for choice in action.choices if str(choice) != "None")) + "}"
    else:
        found = _PLACES.get(name, "")
    if not found:
        kinds = re.findall("INT|FLOAT|STR|PATH", str(action.metavar or ""))
        found = _TYPES[kinds[0]] if kinds else "VALUE"
    return f"{found} [...]" if action.nargs in ("*", "+") else found


def _in_usage(action: argparse.Action, command: Command) -> str:
    name = placeholder(action, command)
    if action.nargs == "*" and not action.required:
        return f"[{name.removesuffix(' [...]')} ...]"
    return f"[{name}]" if action.nargs == "?" else name


def _is_of(action: argparse.Action, part: str) -> bool:
    return action.option_strings[0].startswith(f"{part}.")


def _flag(action: argparse.Action, command: Command) -> str:
    if action.nargs == 0:
        return action.option_strings[1] if action.default is True else action.option_strings[0]
    return f"{action.option_strings[0]} {placeholder(action, command)}"


def _text(action: argparse.Action, options: Collection[str]) -> str:
    """Return the help of an argument, with options as they are typed; the default where the text does not name it."""
    text = re.sub(r"``", "", " ".join(str(action.help or "").split())).replace("%%", "%")
    text, default = re.sub(r" ?\((default: [^()]*|required)\)$", "", text), re.search(r"\(default: ([^()]*)\)$", text)
    text = re.sub(r"\b[a-z]+(?:_[a-z]+)+\b", lambda found: _as_option(found.group(), options), text)
    if action.nargs == 0 and action.default is True:
        return f"Switch off what is on by default: {text[:1].lower()}{text[1:]}"
    if default is None or "default" in text or default.group(1).strip() in ("", "None", "False", "True"):
        return text
    return f"{text.rstrip('.')} (default: {default.group(1)})."


def _as_option(name: str, options: Collection[str]) -> str:
    option = f"--{name.replace('_', '-')}"
    return option if option in options else name


def _row(left: str, right: str, width: int) -> list[str]:
    rest = textwrap.wrap(right, width - 26, break_on_hyphens=False) or [""]
    first = [f"  {left:22}  {rest[0]}"] if len(left) <= 22 else [f"  {left}", f"{'':26}{rest[0]}"]
    return [line.rstrip() for line in [*first, *(f"{'':26}{line}" for line in rest[1:])]]


def _paragraphs(text: str, width: int) -> list[str]:
    parts = [" ".join(part.split()) for part in text.split("\n\n")]
    return [line for part in parts for line in [*textwrap.wrap(part, width, break_on_hyphens=False), ""]][:-1]
