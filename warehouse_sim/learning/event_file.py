"""Curves in the format of TensorBoard, written at once.

tensorboardX's own writer writes from a thread: on a full disk that dies, and then its queue
fills and the training waits for ever.
"""

import time
from pathlib import Path

from tensorboardX.proto.event_pb2 import Event
from tensorboardX.proto.summary_pb2 import Summary
from tensorboardX.record_writer import RecordWriter

from warehouse_sim.output import writing


class EventFile:
    """One file of events.

    Args:
        path: The file to make; its folder must exist.

    Raises:
        OutputError: It cannot be written.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        with writing(path):
            self._records = RecordWriter(str(path))
        self._append(Event(wall_time=time.time(), file_version="brain.Event:2"))

    def write(self, values: dict[str, float], step: int) -> None:
        """Append the values of one step, by tag.

        Raises:
            OutputError: They cannot be written.
        """
        summary = Summary(value=[Summary.Value(tag=tag, simple_value=value) for tag, value in values.items()])
        self._append(Event(wall_time=time.time(), step=step, summary=summary))

    def _append(self, event: Event) -> None:
        with writing(self._path):
            self._records.write(event.SerializeToString())
            self._records.flush()
