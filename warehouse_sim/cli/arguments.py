"""From words on a command line to a call of the command's function; what is wrong becomes one line."""

import argparse
import contextlib
import difflib
import io
import re
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import zip_longest
from typing import Any

import tyro

from warehouse_sim.cli.commands import Command
from warehouse_sim.cli.help_page import page, placeholder
from warehouse_sim.errors import InputError, shown

_NUMBER = re.compile(r"-(\d|\.\d|inf|nan)")
_TOO_LONG = re.compile(r"[-+]?[\d_.]{301,}")
"""More digits than the largest number has that floating point holds; Python reads no more than 4,300."""


def call(command: Command, function: Callable[..., Any], words: Sequence[str]) -> int | None:
    """Run a command.

    Args:
        command: Which one.
        function: What runs it; its signature names the options.
        words: What stands behind the command's name.

    Returns:
        The exit code, None for success.

    Raises:
        InputError: An option is unknown or missing, or a value is of another type.
    """
    for word in words:
        if _TOO_LONG.fullmatch(word):
            raise InputError(
                f"{command.name}: {shown(word)} has {len(word)} digits, which no option takes; {_see(command)}"
            )
    parser = _parser(command, function)
    if any(word in ("-h", "--help", "--help-all") for word in words):
        print(page(command, parser, "--help-all" in words))
        return None
    actions = {name: action for action in parser._actions for name in action.option_strings}
    _require_known(command, actions, words)
    complaint = io.StringIO()
    try:
        with contextlib.redirect_stderr(complaint), contextlib.redirect_stdout(complaint):
            ready = tyro.cli(_deferred(function), args=_python(actions, words), prog=f"warehouse-sim {command.name}")
    except SystemExit as problem:
        raise InputError(
            f"{command.name}: {_one_line(complaint.getvalue(), command, parser)}; {_see(command)}"
        ) from problem
    result: int | None = ready()
    return result


def _deferred(function: Callable[..., Any]) -> Callable[..., Callable[[], Any]]:
    """Return a function of the same signature that only takes the arguments, so that output is not caught."""

    def take(*positional: Any, **named: Any) -> Callable[[], Any]:
        return lambda: function(*positional, **named)

    take.__wrapped__ = function  # type: ignore[attr-defined]  # inspect.signature follows it
    take.__doc__, take.__annotations__ = function.__doc__, function.__annotations__
    take.__name__, take.__module__ = function.__name__, function.__module__
    take.__defaults__, take.__kwdefaults__ = function.__defaults__, function.__kwdefaults__
    return take


def _parser(command: Command, function: Callable[..., Any]) -> argparse.ArgumentParser:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        found: Any = tyro.extras.get_parser(function, prog=f"warehouse-sim {command.name}")
    return found


def _require_known(command: Command, actions: Mapping[str, argparse.Action], words: Sequence[str]) -> None:
    """Reject empty words, options that the command does not have or that get no value, and name those that it lacks.

    Raises:
        InputError: Names the nearest option, or what the option takes.
    """
    if "" in words:
        raise InputError(f"{command.name}: an argument is empty; give it a value, or leave it out")
    given = set[str]()
    for word, following in zip_longest(words, words[1:], fillvalue=""):
        if word in ("-", "--") or not word.startswith("-") or _NUMBER.match(word):
            continue
        option, (_, equals, value) = _option(word), word.partition("=")
        if option not in actions:
            near = _nearest_option(option, actions)
            hint = f"did you mean {near}?" if near else _see(command)
            raise InputError(f"{command.name}: {shown(option)[1:-1]} is not an option; {hint}")
        given.add(option)
        takes = placeholder(actions[option], command)
        if actions[option].nargs == 0 and equals:
            raise InputError(f"{command.name}: {option} takes no value, found {shown(value)}; {_see(command)}")
        if actions[option].nargs != 0 and not (value if equals else following and _option(following) not in actions):
            raise InputError(f"{command.name}: {option} takes {takes}, found nothing; {_see(command)}")
    for name, action in actions.items():
        if action.required and name not in given:
            raise InputError(f"{command.name}: {name} {placeholder(action, command)} is missing; {_see(command)}")


def _option(word: str) -> str:
    return word.partition("=")[0].replace("_", "-")


def _nearest_option(option: str, known: Iterable[str]) -> str | None:
    names = {name.removeprefix("--"): name for name in known if name.startswith("--")}
    text = option.lstrip("-").lower()
    begin = [name for name in names if len(text) > 1 and name.startswith(text)]
    near = begin or difflib.get_close_matches(text, names, n=1, cutoff=0.65)
    return names[near[0]] if near else None


def _python(actions: Mapping[str, argparse.Action], words: Sequence[str]) -> list[str]:
    """Return words as the parser takes them: ``none`` for a number that can be left open is ``None``."""
    optional = {name for name, action in actions.items() if re.match(r"\{None\}\|(INT|FLOAT)", str(action.metavar))}
    ready = list[str]()
    for before, word in zip(["", *words], words, strict=False):
        name, _, value = word.partition("=")
        if word == "none" and _option(before) in optional:
            ready.append("None")
        else:
            ready.append(f"{name}=None" if value == "none" and _option(name) in optional else word)
    return ready


def _see(command: Command) -> str:
    return f"see warehouse-sim {command.name} --help"


def _one_line(text: str, command: Command, parser: argparse.ArgumentParser) -> str:
    """Return a complaint of the parser in one line: what an option takes and what it got, where that is to be seen."""
    lines = [re.sub(r"[╭╮╰╯│─┌┐└┘|]+", " ", line).strip() for line in text.splitlines()]
    whole = " ".join(" ".join(line for line in lines if line).split())
    actions = {name: action for action in parser._actions for name in action.option_strings or [action.dest]}
    if "Missing from" in whole:
        first = next(action for action in parser._actions if action.required and not action.option_strings)
        return f"{placeholder(first, command)} is missing"
    if found := re.search(r"Unrecognized options: (.*?) -{5,}", whole):
        return f"{shown(found.group(1))} is more than it takes"
    if found := re.search(r"Error parsing (?:argument )?'?([\w.-]+)'?: .*?\[(.*?)\]", whole):
        name, given = found.groups()
        if name in actions:
            return f"{name} takes {placeholder(actions[name], command)}, found {given}"
    whole = re.split(r" Argument helptext:| For full helptext| Got errors:", re.sub(r" ?-{5,} ?", " ", whole))[0]
    if found := re.search(r"Error parsing (--[\w.-]+): .*: ('.*?')$", whole):
        return f"{found.group(1)} takes {placeholder(actions[found.group(1)], command)}, found {found.group(2)}"
    if found := re.search(r"invalid choice '(.*?)' for argument '(--[\w.-]+)'", whole):
        given, name = found.groups()
        choices = [str(choice) for choice in actions[name].choices or () if str(choice) != "None"]
        near = difflib.get_close_matches(given.lower(), choices, 1, cutoff=0.4)
        hint = f", did you mean {near[0]}?" if near else ""
        return f"{name} takes {placeholder(actions[name], command)}, found {given!r}{hint}"
    return re.sub(r"^(?:Missing argument|Invalid (?:argument|choice)|Parsing error) ", "", whole.strip()).rstrip(".:")
