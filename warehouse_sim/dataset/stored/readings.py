"""Readings that no format holds, one file each: named arrays and the sensor's pose, uncompressed in a .npz.

Equal readings give equal bytes, and nothing is read that numpy would have to unpickle.
"""

import io
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from warehouse_sim.dataset.files.plain import is_rigid
from warehouse_sim.dataset.stored.contents import SENSOR_NAME, ChannelContents, ReadingContents
from warehouse_sim.errors import DatasetError, shown
from warehouse_sim.schema import CAMERA, RIGHT, ChannelReading, LidarScan, MountedReading, Observation, Reading
from warehouse_sim.schema.readings import units_of

POSE = "T_camera_sensor"
"""What the sensor's pose is called among the arrays."""
_HELD_BY_FORMATS = (CAMERA, RIGHT)
_NUMBERS = "biuf"
_EPOCH = (1980, 1, 1, 0, 0, 0)
_UNREADABLE = (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, NotImplementedError, SyntaxError)

Described = Mapping[str, ChannelContents]


def other_readings(observation: Observation) -> dict[str, MountedReading[Reading]]:
    """Return the readings that formats do not hold, by the name of their sensor: LiDARs and the pair are theirs."""
    return {
        name: item
        for name, item in observation.readings.items()
        if name not in _HELD_BY_FORMATS and not isinstance(item.reading, LidarScan)
    }


def describe(name: str, reading: Reading) -> dict[str, ChannelContents]:
    """Return what each array of a reading is; a reading may state units as ``units`` by channel.

    Raises:
        DatasetError: The sensor's name is no word, or an array holds something else than finite numbers.
    """
    if not SENSOR_NAME.fullmatch(name):
        raise DatasetError(f"the name of a sensor must be small letters, digits and _, found {shown(name)}")
    units = units_of(reading)
    for channel, array in reading.channels.items():
        if channel == POSE or not channel.isidentifier() or np.asarray(array).dtype.kind not in _NUMBERS:
            raise DatasetError(f"sensor {name}: channel {shown(channel)} must be a name with an array of numbers")
        if not np.isfinite(array).all():
            raise DatasetError(
                f"sensor {name}: channel {channel} has values that are not finite; give 0 for no reading"
            )
    return {
        channel: ChannelContents(_stored(array).dtype.str, np.shape(array), str(units.get(channel, "")))
        for channel, array in reading.channels.items()
    }


def merged(name: str, kind: str, described: Sequence[Described], where: Path) -> ReadingContents:
    """Return what a sensor gives in a whole dataset: lengths that differ between observations are left open.

    Raises:
        DatasetError: Channels, types, units or numbers of axes differ.
    """
    first, *others = described
    channels = dict(first)
    for other in others:
        for channel in {*channels, *other}:
            mine, theirs = channels.get(channel), other.get(channel)
            if mine is None or theirs is None or _kind(mine) != _kind(theirs):
                raise DatasetError(
                    f"{where}: sensor {name}: channel {channel} is not the same kind of array in all observations"
                )
            shape = tuple(a if a == b else None for a, b in zip(mine.shape, theirs.shape, strict=True))
            channels[channel] = ChannelContents(mine.dtype, shape, mine.unit)
    return ReadingContents(kind, channels)


def encode_reading(item: MountedReading[Reading]) -> bytes:
    """Return the .npz of a reading, channels in alphabetical order."""
    arrays = {POSE: item.T_camera_sensor, **dict(sorted(item.reading.channels.items()))}
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive:
        for name, array in arrays.items():
            content = io.BytesIO()
            np.lib.format.write_array(content, _stored(array), allow_pickle=False)
            archive.writestr(zipfile.ZipInfo(f"{name}.npy", _EPOCH), content.getvalue())
    return file.getvalue()


def read_reading(path: Path, contents: ReadingContents) -> MountedReading[ChannelReading]:
    """Read what a sensor gave at one observation.

    Raises:
        DatasetError: The file is missing or malformed, or holds other arrays than the manifest says.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            arrays = {item.filename.removesuffix(".npy"): _array(archive, item) for item in archive.infolist()}
    except _UNREADABLE as problem:
        raise DatasetError(f"{path}: cannot be read ({' '.join(str(problem).split())[:100]})") from problem
    pose = arrays.pop(POSE, np.zeros((4, 4)))
    if pose.shape != (4, 4) or pose.dtype != np.float64 or not is_rigid(pose):
        raise DatasetError(f"{path}: {POSE} is no rigid 4x4 transform")
    if set(arrays) != set(contents.channels):
        raise DatasetError(f"{path}: holds {sorted(arrays)}, the manifest says {sorted(contents.channels)}")
    for name, expected in contents.channels.items():
        found = arrays[name]
        fits = len(found.shape) == len(expected.shape) and all(
            length in (None, own) for length, own in zip(expected.shape, found.shape, strict=True)
        )
        if found.dtype.str != expected.dtype or not fits:
            raise DatasetError(
                f"{path}: {name} is {found.dtype.str} of shape {found.shape}, "
                f"the manifest says {expected.dtype} of shape {expected.shape}"
            )
        if not np.isfinite(found).all():
            raise DatasetError(f"{path}: {name} has values that are not finite")
    return MountedReading(pose, ChannelReading(arrays))


def _kind(channel: ChannelContents) -> tuple[str, int, str]:
    return channel.dtype, len(channel.shape), channel.unit


def _stored(array: np.ndarray) -> np.ndarray:
    """Return an array as it is stored: row by row, little-endian."""
    array = np.asarray(array)
    return np.ascontiguousarray(array, array.dtype.newbyteorder("<")).reshape(array.shape)


def _array(archive: zipfile.ZipFile, item: zipfile.ZipInfo) -> np.ndarray:
    """Read one array; its header cannot require more memory than the file has bytes."""
    if item.compress_type != zipfile.ZIP_STORED:
        raise ValueError(f"{item.filename} is compressed")
    content = io.BytesIO(archive.read(item))
    if np.lib.format.read_magic(content) != (1, 0):
        raise ValueError(f"{item.filename} is no array of version 1.0")
    shape, fortran_order, dtype = np.lib.format.read_array_header_1_0(content)
    if fortran_order or dtype.kind not in _NUMBERS:
        raise ValueError(f"{item.filename} holds {dtype.str}")
    return np.frombuffer(content.read(), dtype).reshape(shape)
