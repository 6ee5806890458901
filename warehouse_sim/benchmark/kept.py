"""What was made before is used again only where all that it was made of is the same."""

import hashlib
import json
from pathlib import Path
from typing import Any

from warehouse_sim.config import to_mapping
from warehouse_sim.dataset.files.json_file import read_json, write_json
from warehouse_sim.errors import DatasetError

INPUTS = "inputs.json"
"""In the folder of what is kept, written last: what it was made of."""


def digest(inputs: Any) -> str:
    """Return the SHA-256 of plain data, whatever the order of its keys."""
    text = json.dumps(to_mapping(inputs), sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode("utf-8")).hexdigest()


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a file, or of all files under a folder with their names."""
    if path.is_file():
        return hashlib.sha256(path.read_bytes()).hexdigest()
    whole = hashlib.sha256()
    for file in sorted(item for item in path.rglob("*") if item.is_file()):
        whole.update(f"{file.relative_to(path).as_posix()}\n".encode())
        whole.update(hashlib.sha256(file.read_bytes()).digest())
    return whole.hexdigest()


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
