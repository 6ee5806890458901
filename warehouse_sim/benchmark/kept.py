"""What was made before is used again only where all that it was made of is the same."""

import hashlib
import json
import os
from pathlib import Path
from typing import Any

from warehouse_sim.config import to_mapping
from warehouse_sim.dataset.files.checksums import file_sum
from warehouse_sim.dataset.files.json_file import read_json, write_json
from warehouse_sim.errors import DatasetError
from warehouse_sim.estimators.own.program import PROGRAM, words_of
from warehouse_sim.estimators.own.source import is_own_source, source_file
from warehouse_sim.resources import data_folder

INPUTS = "inputs.json"
"""In the folder of what is kept, written last: what it was made of."""


def digest(inputs: Any) -> str:
    """Return the SHA-256 of plain data, whatever the order of its keys."""
    text = json.dumps(to_mapping(inputs), sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode("utf-8")).hexdigest()


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a file, or of all files under a folder with their names."""
    if path.is_file():
        return file_sum(path)
    whole = hashlib.sha256()
    for file in sorted(item for item in path.rglob("*") if item.is_file()):
        whole.update(f"{file.relative_to(path).as_posix()}\n".encode())
        whole.update(hashlib.sha256(file.read_bytes()).digest())
    return whole.hexdigest()


_DECIDES = ("*.safetensors", "config.yaml", "calibration.yaml", "uncertainty.yaml")
"""What of a model's folder its answers depend on."""


def weights_digest(name: str) -> str:
    """Return the SHA-256 of all files that a model's answers depend on; empty where there are none.

    Of a user's own estimator that is the file which holds it; of a program, the files that its command names.

    Raises:
        InputError: The name is that of a program, and no command.
    """
    if name.startswith(PROGRAM):
        files = [Path(word) for word in words_of(name.removeprefix(PROGRAM)) if os.path.isfile(word)]
    elif is_own_source(name):
        files = [file] if (file := source_file(name)) else []
    elif Path(name).is_file():  # of detections
        files = [Path(name)]
    else:
        folder = Path(name) if Path(name).is_dir() else data_folder("models") / name
        files = sorted(path for pattern in _DECIDES for path in folder.glob(pattern))
    return digest([[path.name, file_digest(path)] for path in files]) if files else ""


def folder_for(root: Path, name: str, inputs: Any) -> Path:
    """Return where that which is made of ``inputs`` is kept: another place for every change of them."""
    readable = "".join(letter if letter.isalnum() or letter in "-_.@+" else "-" for letter in name)
    return root / f"{readable}-{digest(inputs)[:12]}"


def is_kept(folder: Path, inputs: Any) -> bool:
    """Return whether a folder holds what was made of exactly these inputs, to its end."""
    path = folder / INPUTS
    if not path.is_file():
        return False
    try:
        return digest(read_json(path)) == digest(inputs)
    except DatasetError:
        return False


def keep(folder: Path, inputs: Any) -> None:
    """Say that a folder is complete, and what it was made of."""
    write_json(folder / INPUTS, to_mapping(inputs), depth=2)
