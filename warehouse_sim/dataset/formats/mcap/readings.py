"""Messages of all other sensors, as JSON: their arrays by name, with a schema that says shapes and units."""

import json
from typing import Any

import numpy as np

from warehouse_sim.dataset.files.plain import plain
from warehouse_sim.schema import Reading

_SECOND = 1_000_000_000
_TIME = {
    "type": "object",
    "title": "time",
    "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}},
}


def reading_schema(reading: Reading) -> bytes:
    """Return the JSON schema of a sensor's messages."""
    units = getattr(reading, "units", {})
    properties: dict[str, Any] = {"timestamp": _TIME, "frame_id": {"type": "string"}}
    for name, array in sorted(reading.channels.items()):
        properties[name] = _array(np.asarray(array)) | {"description": str(units.get(name, ""))}
    return json.dumps({"type": "object", "properties": properties}).encode("ascii")


def reading_message(stamp: int, frame: str, reading: Reading) -> bytes:
    """Return a sensor's arrays as JSON, every digit of them."""
    time = {"sec": stamp // _SECOND, "nsec": stamp % _SECOND}
    arrays = {name: plain(np.asarray(array)) for name, array in sorted(reading.channels.items())}
    return json.dumps({"timestamp": time, "frame_id": frame, **arrays}, allow_nan=False).encode("ascii")


def _array(array: np.ndarray) -> dict[str, Any]:
    kinds = {"f": "number", "b": "boolean"}
    schema: dict[str, Any] = {"type": kinds.get(array.dtype.kind, "integer")}
    for _ in range(array.ndim):
        schema = {"type": "array", "items": schema}
    return schema
