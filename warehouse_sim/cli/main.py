"""The commands of ``warehouse-sim``, and how errors leave it: one clear line and exit code 2."""

import errno
import io
import logging
import os
import sys
from collections.abc import Callable, Sequence
from typing import Any

import tyro

from warehouse_sim.cli.bench import bench
from warehouse_sim.cli.catalog import catalog
from warehouse_sim.cli.check_scene import check_scene
from warehouse_sim.cli.convert import convert
from warehouse_sim.cli.demo import demo
from warehouse_sim.cli.detect import detect
from warehouse_sim.cli.evaluate import evaluate
from warehouse_sim.cli.export import export
from warehouse_sim.cli.export_scene import export_scene
from warehouse_sim.cli.generate import generate
from warehouse_sim.cli.inspect import inspect
from warehouse_sim.cli.list import list_names
from warehouse_sim.cli.merge import merge
from warehouse_sim.cli.predict import predict
from warehouse_sim.cli.preview import preview
from warehouse_sim.cli.reach import reach
from warehouse_sim.cli.renamed import reject_renamed
from warehouse_sim.cli.report import report
from warehouse_sim.cli.train import train, train_command
from warehouse_sim.cli.validate import validate
from warehouse_sim.cli.verify import verify
from warehouse_sim.cli.view import view
from warehouse_sim.errors import InputError, WarehouseSimError

_NO_PATHS = (errno.ENAMETOOLONG, errno.ELOOP)
"""What no path can be, whoever asks first whether something is there."""

COMMANDS: dict[str, Callable[..., Any]] = {
    "list": list_names,
    "catalog": catalog,
    "preview": preview,
    "check-scene": check_scene,
    "generate": generate,
    "merge": merge,
    "convert": convert,
    "validate": validate,
    "reach": reach,
    "verify": verify,
    "view": view,
    "inspect": inspect,
    "train": train,
    "detect": detect,
    "predict": predict,
    "export": export,
    "export-scene": export_scene,
    "evaluate": evaluate,
    "report": report,
    "bench": bench,
    "demo": demo,
}


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
        if any("\0" in argument for argument in arguments or ()):  # a shell cannot pass one, a program can
            raise InputError("an argument holds a zero byte; names and paths cannot")
        given = sys.argv[1:] if arguments is None else arguments
        reject_renamed(given)
        result: int | None = tyro.extras.subcommand_cli_from_dict(
            COMMANDS | {"train": train_command(given)},
            prog="warehouse-sim",
            description="Generate synthetic warehouse datasets; train and score 6D-pose estimators on them.",
            args=arguments,
        )
    except WarehouseSimError as error:
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
    return int(result or 0)
