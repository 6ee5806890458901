"""Arrays that grow on disk row by row and are then read as if they were in memory."""

import os
import warnings
from pathlib import Path

import numpy as np
import torch
from torch import Tensor


class GrowingArray:
    """An .npy file to which rows are appended; its length is written at the end.

    Args:
        path: File to make.
        row_shape: Shape of one row.
        dtype: Type of the numbers.
    """

    def __init__(self, path: Path, row_shape: tuple[int, ...], dtype: np.dtype) -> None:
        self._row_shape, self._dtype, self._count = row_shape, dtype, 0
        self._file = path.open("wb")
        self._header = self._write_header()

    def append(self, rows: np.ndarray) -> None:
        """Write more rows.

        Raises:
            ValueError: They have another shape or type than the first.
        """
        if rows.shape[1:] != self._row_shape or rows.dtype != self._dtype:
            raise ValueError(f"rows of {self._row_shape} {self._dtype} expected, found {rows.shape[1:]} {rows.dtype}")
        self._file.write(np.ascontiguousarray(rows).data)
        self._count += len(rows)

    def close(self) -> None:
        """Write the number of rows and force the file to the disk."""
        self._file.seek(0)
        # numpy leaves room for the first axis to grow, so that the header keeps its length.
        assert self._write_header() == self._header
        self._file.flush()
        os.fsync(self._file.fileno())
        self._file.close()

    def _write_header(self) -> int:
        header = {
            "descr": np.lib.format.dtype_to_descr(self._dtype),
            "fortran_order": False,
            "shape": (self._count, *self._row_shape),
        }
        np.lib.format.write_array_header_1_0(self._file, header)
        return self._file.tell()


def map_array(path: Path) -> np.ndarray:
    """Return the array of an .npy file without reading it; its pages come from the disk when they are touched.

    Raises:
        OSError: The file cannot be read.
        ValueError: It is no array, or shorter than it says.
    """
    return np.load(path, mmap_mode="r", allow_pickle=False)


def shared_tensor(array: np.ndarray) -> Tensor:
    """Return a tensor in the memory of ``array``, which must only be read."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*not writable.*")
        return torch.from_numpy(array)
