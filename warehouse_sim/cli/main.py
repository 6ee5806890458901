"""The command line: which command runs, and how errors leave it: one clear line and exit code 2."""

import difflib
import errno
import io
import logging
import os
import sys
from collections.abc import Sequence

from warehouse_sim.cli.commands import COMMANDS
from warehouse_sim.errors import EstimatorError, InputError, WarehouseSimError, shown
from warehouse_sim.version import __version__

_NO_PATHS = (errno.ENAMETOOLONG, errno.ELOOP)
"""What no path can be, whoever asks first whether something is there."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        arguments: Command line without the program's name; ``sys.argv[1:]`` by default.

    Returns:
        The exit code: 0 for success, 1 when checks did not hold, 2 for wrong input, 130 when interrupted,
        141 when stdout was closed.
    """
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(line_buffering=True)  # in a log file, results stand between the progress they belong to
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s: %(message)s", stream=sys.stderr)
    try:
        return int(_run(sys.argv[1:] if arguments is None else arguments) or 0)
    except WarehouseSimError as error:
        if isinstance(error, EstimatorError) and error.details:
            print(error.details, file=sys.stderr)
        print(f"error: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:
        # Who read stdout, such as head, has seen enough. Nor shall Python write there when it ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except OSError as error:
        if error.errno not in _NO_PATHS or error.filename is None:
            raise
        print(f"error: {error.filename}: {error.strerror}; give another path", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("interrupted; the same command with --resume goes on where it stopped", file=sys.stderr)
        return 130


def _run(words: Sequence[str]) -> int | None:
    if any("\0" in word for word in words):  # a shell cannot pass one, a program can
        raise InputError("an argument holds a zero byte; names and paths cannot")
    if not words or words[0] in ("-h", "--help"):
        from warehouse_sim.cli.help_page import overview

        print(overview())
        return None if words else 2
    if words[0] == "--version":
        print(f"warehouse-sim {__version__}")
        return None
    if words[0] not in COMMANDS:
        near = difflib.get_close_matches(words[0], COMMANDS, n=1, cutoff=0.5)
        hint = f"did you mean {near[0]}?" if near else "see warehouse-sim --help"
        raise InputError(f"{shown(words[0])} is not a command; {hint}")
    if words[0] == "generate":
        # Its matrices are small: more threads only wait for each other. numpy reads it when it is imported.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from warehouse_sim.cli.arguments import call

    command = COMMANDS[words[0]]
    function = command.function()
    if command.name == "train":
        from warehouse_sim.cli.commands.train import train_command

        function = train_command(words)
    return call(command, function, words[1:])
