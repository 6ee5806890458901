"""Where observations are streamed to: a file, or a viewer on this machine."""

import json
import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from warehouse_sim.errors import InputError
from warehouse_sim.optional import require
from warehouse_sim.output import partial_file, writing

_APPLICATION = "warehouse_sim"
_SCREENS = ("DISPLAY", "WAYLAND_DISPLAY")
_PORT = 9876
_SETTINGS = "XDG_CONFIG_HOME"
_REMEDY = "write a file with --save FILE.rrd and open it with 'rerun FILE.rrd' where there is one"


@contextmanager
def open_recording(name: str, save: Path | None, port: int = _PORT) -> Iterator[Any]:
    """Yield a stream of Rerun that goes to a file or to a viewer, which is started.

    A file gets its name when all is in it. A viewer listens on the loopback address.

    Args:
        name: Of the recording: the same dataset has the same one.
        save: File to write (.rrd); None = a viewer.
        port: Where a viewer listens, on the loopback address.

    Raises:
        MissingPackageError: Rerun is not installed.
        InputError: There is no screen, or no viewer could be started.
        OutputError: The file cannot be written.
    """
    rerun = require("rerun", "view", "to view a dataset")
    recording = rerun.RecordingStream(_APPLICATION, recording_id=name, send_properties=False)
    # When something was streamed says nothing of it.
    rerun.set_log_time_enabled(False, recording=recording)
    rerun.set_log_tick_enabled(False, recording=recording)
    if save is None:
        with _silent_viewer():
            _spawn(recording, port)
            yield recording
            recording.flush()
            recording.disconnect()
        return
    partial = partial_file(save)
    with writing(save):
        partial.touch()
    try:
        recording.save(partial)
        yield recording
        recording.flush()
        recording.disconnect()
    except BaseException:
        recording.disconnect()
        partial.unlink(missing_ok=True)
        raise
    with writing(save):
        os.replace(partial, save)


@contextmanager
def _silent_viewer() -> Iterator[None]:
    """Let viewers that are started meanwhile send no statistics of their use to their makers.

    They read so in a folder of settings that is theirs alone; those of the user stay as they are.
    """
    before = os.environ.get(_SETTINGS)
    with tempfile.TemporaryDirectory(prefix="warehouse_sim-") as folder:
        path = Path(folder) / "rerun" / "analytics.json"
        path.parent.mkdir()
        silent = {"analytics_enabled": False, "analytics_id": "", "metadata": {}}
        data = str(path.parent)
        path.write_text(json.dumps(silent | {"config_file_path": str(path), "data_dir_path": data}))
        os.environ[_SETTINGS] = folder
        try:
            yield
        finally:
            if before is None:
                del os.environ[_SETTINGS]
            else:
                os.environ[_SETTINGS] = before


def _spawn(recording: Any, port: int) -> None:
    """Start a viewer.

    Raises:
        InputError: It cannot show anything here.
    """
    if sys.platform.startswith("linux") and not any(map(os.environ.get, _SCREENS)):
        raise InputError(f"no screen for the Rerun viewer: {' and '.join(_SCREENS)} are not set; {_REMEDY}")
    try:
        recording.spawn(port=port, hide_welcome_screen=True)
    except RuntimeError as problem:
        reason = " ".join(str(problem).split())[:200]
        raise InputError(f"the Rerun viewer could not be started ({reason}); {_REMEDY}") from problem
