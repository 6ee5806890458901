"""An MCAP file while it is written: topics as they come, the same bytes for the same messages."""

import os
from pathlib import Path
from typing import Any

from google.protobuf.message import Message
from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import CompressionType, Writer
from mcap_protobuf.schema import build_file_descriptor_set

from warehouse_sim.output import partial_file, writing

_LIBRARY = "warehouse-sim"
"""What wrote the file; without versions, which are in the manifest."""


class McapFile:
    """A file under a temporary name, which gets its own when it is finished.

    Args:
        path: Where it will be.
        about: Words on the whole file, stored as its metadata.

    Raises:
        OutputError: It cannot be written.
    """

    def __init__(self, path: Path, about: dict[str, str]) -> None:
        self._path, self._partial = path, partial_file(path)
        with writing(path):
            self._stream = open(self._partial, "wb")  # noqa: SIM115
            self._writer = Writer(self._stream, compression=CompressionType.ZSTD)
            self._writer.start(profile="", library=_LIBRARY)
            self._writer.add_metadata(_LIBRARY, about)
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._counts: dict[str, int] = {}

    def add(self, topic: str, stamp: int, message: Message) -> None:
        """Add a protobuf message to a topic.

        Args:
            topic: Of messages of one type.
            stamp: Time stamp (ns since 1970).
            message: The message.
        """
        if topic not in self._channels:
            self._open(topic, message.DESCRIPTOR.full_name, SchemaEncoding.Protobuf, MessageEncoding.Protobuf, message)
        self._add(topic, stamp, message.SerializeToString(deterministic=True))

    def add_json(self, topic: str, stamp: int, name: str, schema: bytes, content: bytes) -> None:
        """Add a message in JSON to a topic; ``name`` is that of its JSON schema."""
        if topic not in self._channels:
            self._open(topic, name, SchemaEncoding.JSONSchema, MessageEncoding.JSON, schema)
        self._add(topic, stamp, content)

    def finish(self) -> None:
        """Write the index and give the file its name."""
        with writing(self._path):
            self._writer.finish()
            self._stream.close()
            os.replace(self._partial, self._path)

    def _open(self, topic: str, name: str, schema_encoding: str, encoding: str, schema: Any) -> None:
        if name not in self._schemas:
            data = schema if isinstance(schema, bytes) else _described(schema)
            self._schemas[name] = self._writer.register_schema(name, schema_encoding, data)
        self._channels[topic] = self._writer.register_channel(topic, encoding, self._schemas[name])

    def _add(self, topic: str, stamp: int, data: bytes) -> None:
        count = self._counts.get(topic, 0)
        with writing(self._path):
            self._writer.add_message(self._channels[topic], stamp, data, publish_time=stamp, sequence=count)
        self._counts[topic] = count + 1


def _described(message: Message) -> bytes:
    content: bytes = build_file_descriptor_set(type(message)).SerializeToString(deterministic=True)
    return content
