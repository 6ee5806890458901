"""Croissant 1.0 metadata of a dataset folder: what search engines for data and loaders of machine learning read.

The format: https://docs.mlcommons.org/croissant/docs/croissant-spec.html
"""

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from warehouse_sim.dataset.manifest import Manifest, read_manifest
from warehouse_sim.output import write_bytes
from warehouse_sim.version import __version__

FILE = "croissant.json"
"""Its usual name; file names in it count from the folder that it lies in."""
_PICTURES = {".png": "image/png", ".jpg": "image/jpeg"}
_KINDS = {**_PICTURES, ".json": "application/json", ".txt": "text/plain", ".csv": "text/csv", ".md": "text/markdown"}
_TERMS = [
    "citeAs",
    "column",
    "equivalentProperty",
    "extract",
    "field",
    "fileObject",
    "fileProperty",
    "fileSet",
    "format",
    "includes",
    "isLiveDataset",
    "jsonPath",
    "key",
    "md5",
    "parentField",
    "path",
    "recordSet",
    "references",
    "regex",
    "repeated",
    "replace",
    "samplingRate",
    "separator",
    "source",
    "subField",
    "transform",
]
_CONTEXT: dict[str, Any] = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "sc": "https://schema.org/",
    "cr": "http://mlcommons.org/croissant/",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "dct": "http://purl.org/dc/terms/",
    "conformsTo": "dct:conformsTo",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "examples": {"@id": "cr:examples", "@type": "@json"},
    **{name: f"cr:{name}" for name in _TERMS},
}


@dataclass(frozen=True)
class About:
    """What is said of a folder."""

    name: str
    description: str
    cite: str
    """How to cite it."""
    keywords: tuple[str, ...]
    """Besides those of all synthetic warehouses."""
    licence: str
    """Empty where none is stated."""


def write_croissant(root: Path, path: Path) -> Path:
    """Write the metadata of a dataset, and return where they are.

    Args:
        root: Folder of the dataset.
        path: The JSON file, in that folder or above it: it names files relative to where it lies.

    Raises:
        DatasetError: The folder holds no dataset.
        OutputError: The file cannot be written.
    """
    return write_metadata(croissant(root, root.resolve().relative_to(path.resolve().parent).as_posix()), path)


def write_metadata(data: dict[str, Any], path: Path) -> Path:
    """Write metadata and return where they are."""
    write_bytes(path, (json.dumps(data, indent=2, ensure_ascii=False) + "\n").encode("utf-8"))
    return path


def croissant(root: Path, prefix: str) -> dict[str, Any]:
    """Return the metadata of a dataset.

    Args:
        root: Folder of the dataset.
        prefix: What stands before the names of its files; "." for nothing.

    Raises:
        DatasetError: The folder holds no dataset.
    """
    manifest = read_manifest(root)
    name = manifest.contents.name
    about = About(
        name=name,
        description=_description(manifest),
        cite=f"warehouse_sim {__version__}: {name}, seed {manifest.seed}",
        keywords=("6D pose", *manifest.targets),
        licence=manifest.licences.get("data", ""),
    )
    return described(root, prefix, about)


def described(root: Path, prefix: str, about: About) -> dict[str, Any]:
    """Return the metadata of a folder of images and tables.

    Args:
        root: The folder.
        prefix: What stands before the names of its files; "." for nothing.
        about: What is said of it.
    """
    before = "" if prefix == "." else f"{prefix}/"
    top = [path for path in sorted(root.iterdir()) if path.is_file() and path.suffix in _KINDS and path.name != FILE]
    sets = {name: pattern for name, pattern in _patterns(root) if Path(pattern).suffix in _KINDS}
    facts = {
        "@context": _CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "name": about.name,
        "description": about.description,
        "version": __version__,
        "citeAs": about.cite,
        "creator": {"@type": "sc:Organization", "name": "warehouse_sim"},
        "keywords": ["synthetic data", "warehouse", *about.keywords],
        "isLiveDataset": False,
        "distribution": [
            *(_file(path, before) for path in top),
            *(_set(name, f"{before}{pattern}") for name, pattern in sets.items()),
        ],
        "recordSet": [_images(name) for name, pattern in sets.items() if Path(pattern).suffix in _PICTURES],
    }
    return facts | ({"license": about.licence} if about.licence else {})


def _description(manifest: Manifest) -> str:
    splits = ", ".join(f"{len(scenes)} {name}" for name, scenes in manifest.splits.items())
    return (
        f"{manifest.contents.description.rstrip('.')}. {manifest.scenes} scenes ({splits}) of "
        f"{manifest.observations_per_scene} observations, seed {manifest.seed}, made by warehouse_sim; formats: "
        f"{', '.join(manifest.formats)}; labels of {', '.join(manifest.targets)}."
    )


def _patterns(root: Path) -> Iterable[tuple[str, str]]:
    """Yield a name and a pattern for each kind of file below the top: ``bop-rgb`` and ``bop/*/*/rgb/*.png``."""
    found: dict[str, str] = {}
    for path in sorted(root.rglob("*")):
        *folders, name = path.relative_to(root).parts
        if not folders or not path.is_file():
            continue
        named = [folder for folder in folders[1:][-1:] if not folder.isdigit()]
        middle = ["*"] * (len(folders) - 1 - len(named))
        suffix = Path(name).suffix
        found.setdefault("/".join([folders[0], *middle, *named, f"*{suffix}"]), "-".join([folders[0], *named]))
    for pattern, name in found.items():
        double = list(found.values()).count(name) > 1
        yield (f"{name}{Path(pattern).suffix}-{pattern.count('/')}" if double else name), pattern


def _file(path: Path, before: str) -> dict[str, Any]:
    return {
        "@type": "cr:FileObject",
        "@id": path.name,
        "name": path.name,
        "contentUrl": f"{before}{path.name}",
        "encodingFormat": _KINDS[path.suffix],
        "sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
    }


def _set(name: str, pattern: str) -> dict[str, Any]:
    return {
        "@type": "cr:FileSet",
        "@id": name,
        "name": name,
        "encodingFormat": _KINDS[Path(pattern).suffix],
        "includes": pattern,
    }


def _images(name: str) -> dict[str, Any]:
    """Return a set of records, one for each image of a set of files."""
    fields = (("path", "sc:Text", "fullpath"), ("image", "sc:ImageObject", "content"))
    return {
        "@type": "cr:RecordSet",
        "@id": f"{name}-images",
        "name": f"{name}-images",
        "field": [
            {
                "@type": "cr:Field",
                "@id": f"{name}-images/{field}",
                "name": field,
                "dataType": kind,
                "source": {"fileSet": {"@id": name}, "extract": {"fileProperty": what}},
            }
            for field, kind, what in fields
        ],
    }
