"""A dataset folder to break: random places in it, and its files as plain data, read and written without the package.

A file is replaced and never written into: in a copy of hard links the original keeps its bytes.
"""

import hashlib
import json
import os
import shutil
import struct
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np


def linked_copy(source: Path, target: Path) -> Path:
    """Copy a folder without copying a byte."""
    return Path(shutil.copytree(source, target, copy_function=os.link))


@dataclass(frozen=True)
class View:
    """One observation of a dataset with KITTI and BOP files."""

    root: Path
    split: str
    scene: int
    image: int
    frame: int

    @property
    def bop(self) -> Path:
        return self.root / "bop" / self.split / f"{self.scene:06d}"

    @property
    def record(self) -> Path:
        return self.root / "scenes" / f"{self.scene:06d}.json"

    def table(self, name: str) -> Path:
        return self.bop / f"scene_{name}.json"

    def bop_image(self, kind: str) -> Path:
        return self.bop / kind / f"{self.image:06d}.png"

    def mask(self, kind: str, index: int) -> Path:
        return self.bop / kind / f"{self.image:06d}_{index:06d}.png"

    def kitti(self, kind: str, ending: str) -> Path:
        folder = "testing" if self.split == "test" else "training"
        return self.root / "kitti" / folder / kind / f"{self.frame:06d}.{ending}"

    def infos(self) -> list[dict]:
        return load(self.table("gt_info"))[str(self.image)]


@dataclass(frozen=True)
class Folder:
    """A dataset, and where in it a fault goes."""

    root: Path
    rng: np.random.Generator

    def views(self) -> list[View]:
        manifest = load(self.root / "manifest.json")
        count = manifest["observations_per_scene"]
        return [
            View(self.root, split, scene, image, scene * count + image)
            for split, scenes in manifest["splits"].items()
            for scene in scenes
            for image in range(count)
        ]

    def view(self) -> View:
        return self.views()[self.rng.integers(len(self.views()))]

    def target(self, least_px: int = 1) -> tuple[View, int]:
        """Return a view and the number of a target that shows so many pixels at least."""
        found = [
            (view, i)
            for view in self.views()
            for i, info in enumerate(view.infos())
            if info["px_count_visib"] >= least_px
        ]
        return found[self.rng.integers(len(found))]

    def pair(self, least_px: int = 1) -> tuple[View, int, int]:
        """Return a view and two of its targets that show so many pixels at least."""
        view, index = self.target(least_px)
        others = [i for i, info in enumerate(view.infos()) if info["px_count_visib"] >= least_px and i != index]
        return (view, index, int(self.rng.choice(others))) if others else self.pair(least_px)

    def model(self) -> str:
        return str(self.rng.choice(list(load(self.root / "objects.json"))))


def load(path: Path) -> Any:
    return json.loads(path.read_text())


def replace(path: Path, content: bytes) -> None:
    path.unlink()
    path.write_bytes(content)


def edit(path: Path, change: Callable[[Any], object]) -> None:
    """Let ``change`` alter the data of a JSON file."""
    data = load(path)
    change(data)
    replace(path, json.dumps(data).encode())


def edit_image(path: Path, change: Callable[[np.ndarray], np.ndarray]) -> None:
    pixels = change(cv2.imread(str(path), cv2.IMREAD_UNCHANGED))
    replace(path, cv2.imencode(".png", np.ascontiguousarray(pixels))[1].tobytes())


def edit_numbers(path: Path, dtype: str, columns: int, change: Callable[[np.ndarray], np.ndarray]) -> None:
    """Change a binary file of numbers, row by row."""
    rows = np.fromfile(path, dtype).reshape(-1, columns)
    replace(path, np.ascontiguousarray(change(rows.copy()), dtype).tobytes())


def edit_lines(path: Path, change: Callable[[list[list[str]]], object]) -> None:
    """Change the words of a text file."""
    rows = [line.split(" ") for line in path.read_text().splitlines()]
    change(rows)
    replace(path, "".join(" ".join(row) + "\n" for row in rows).encode())


def edit_label(folder: Folder, change: Callable[[list[str]], object]) -> None:
    """Change the words of one row of KITTI's labels."""
    view = folder.target()[0]
    edit_lines(view.kitti("label_2", "txt"), lambda rows: change(rows[folder.rng.integers(len(rows))]))


def edit_row(view: View, table: str, index: int, change: Callable[[Any], object]) -> None:
    """Change the row of a target in a table of BOP."""
    edit(view.table(table), lambda data: change(data[str(view.image)][index]))


def edit_calib(view: View, key: str, change: Callable[[np.ndarray], np.ndarray]) -> None:
    def on(rows: list[list[str]]) -> None:
        for row in rows:
            if row[0] == f"{key}:":
                row[1:] = [f"{value:.12e}" for value in change(np.array(row[1:], float).reshape(3, -1)).ravel()]

    edit_lines(view.kitti("calib", "txt"), on)


def exchange(first: Path, second: Path) -> None:
    """Let two files change places."""
    a, b = first.read_bytes(), second.read_bytes()
    replace(first, b)
    replace(second, a)


def edit_vertices(root: Path, number: str, change: Callable[[np.ndarray], np.ndarray], sums: bool = True) -> None:
    """Change the vertices of both meshes of a model, and put the checksums right unless told otherwise."""
    for folder in (root / "bop/models", root / "bop/models_eval"):
        path = folder / f"obj_{int(number):06d}.ply"
        head, _, body = path.read_bytes().partition(b"end_header\n")
        words = [line.split() for line in head.decode().splitlines()]
        count = next(int(row[2]) for row in words if row[:2] == ["element", "vertex"])
        end = next(i for i, row in enumerate(words) if row[:2] == ["element", "face"])
        kinds = {"float": "f", "double": "d", "uchar": "B"}
        fields = [(row[2], "<" + kinds[row[1]]) for row in words[:end] if row[0] == "property"]
        layout = np.dtype(fields)
        rows = np.frombuffer(body[: count * layout.itemsize], layout).copy()
        moved = change(np.stack([rows[axis] for axis in "xyz"], axis=1).astype(float))
        for axis, values in zip("xyz", moved.T, strict=True):
            rows[axis] = values
        replace(path, head + b"end_header\n" + rows.tobytes() + body[count * layout.itemsize :])
        if sums:
            put_sums_right(path)


def put_sums_right(path: Path) -> None:
    sums = path.parent / "SHA256SUMS"
    rows = [line.split("  ") for line in sums.read_text().splitlines()]
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    replace(sums, "".join(f"{digest if name == path.name else old}  {name}\n" for old, name in rows).encode())


def png_without_end(content: bytes) -> bytes:
    """Cut a PNG within its first block of pixels."""
    start = content.index(b"IDAT")
    (length,) = struct.unpack(">I", content[start - 4 : start])
    return content[: start + 4 + length // 2]
