"""List the licences of all locked packages, as the packages themselves state them.

    pip install --target SITE --no-deps --require-hashes -r locks/dev.txt   # and each other lock whose packages lack
    python -m locks.licences --site SITE

Packages that are installed in neither place keep the row that they have, if it is of the same version.
"""

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import Distribution, distributions
from pathlib import Path

import tyro

LOCKS = Path(__file__).parent
TABLE = LOCKS / "licences.csv"
_PIN = re.compile(r"^([A-Za-z0-9._-]+)==([^\s;]+)", re.MULTILINE)
_LONGEST = 60
"""Longer texts in the field are the licence itself, not its name."""
_COPYLEFT = re.compile(r"\b(A?GPL(?!\w)|Affero|(?<!Lesser )General Public)", re.IGNORECASE)


@dataclass(frozen=True)
class Licensed:
    """A package of a lock and what it may be used under."""

    name: str
    version: str
    licence: str
    """An SPDX expression, or the names of the package's classifiers; empty where nothing is known."""


def plain(name: str) -> str:
    """Return a package's name as locks write it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def locked() -> dict[str, str]:
    """Return versions by name of all packages in the locks, without the local part of a version (``+cpu``).

    NVIDIA's own, which are proprietary and installed only where there is a driver of theirs, are not among them.
    """
    files = sorted(path for path in LOCKS.glob("*.txt") if path.stem != "torch-cuda")
    pins = [pin for path in files for pin in _PIN.findall(path.read_text(encoding="utf-8"))]
    return {plain(name): version.partition("+")[0] for name, version in pins}


def stated_licence(found: Distribution) -> str:
    """Return what a package's metadata says: the expression, else its classifiers, else a short text, else nothing."""
    metadata = found.metadata
    if expression := metadata.get("License-Expression"):
        return " ".join(expression.split())
    classifiers = [line for line in metadata.get_all("Classifier") or [] if line.startswith("License ::")]
    if named := [line.rpartition(" :: ")[2] for line in classifiers if line.count(" :: ") > 1]:
        return " OR ".join(named)
    text = (metadata.get("License") or "").strip()
    return _read_licence(found) if "\n" in text or len(text) > _LONGEST or text in ("", "UNKNOWN") else text


def _read_licence(found: Distribution) -> str:
    """Return which BSD licence the text beside a package is, if it is one."""
    folder = Path(str(found.locate_file(""))) / f"{found.metadata['Name']}-{found.version}.dist-info" / "licenses"
    text = (folder / "LICENSE").read_text(encoding="utf-8") if (folder / "LICENSE").is_file() else ""
    if "Redistribution and use in source and binary forms" not in text:
        return ""
    return "BSD-3-Clause" if "Neither the name" in text else "BSD-2-Clause"


def is_copyleft(licence: str) -> bool:
    """Return whether no alternative of a licence is free of the GPL and the AGPL; an exception for linking frees it."""
    ways = re.split(r"\s+OR\s+", licence.replace("(", "").replace(")", ""))
    return all(any(_binds(part) for part in re.split(r"\s+AND\s+", way)) for way in ways)


def _binds(part: str) -> bool:
    return bool(_COPYLEFT.search(part)) and "exception" not in part.lower()


def read_table() -> list[Licensed]:
    """Return the list that is stored."""
    with TABLE.open(encoding="utf-8", newline="") as stream:
        return [Licensed(**row) for row in csv.DictReader(stream)]


def installed(sites: Sequence[str] | None = None) -> Mapping[str, Distribution]:
    """Return the packages of some folders, by default those of this interpreter."""
    there = distributions() if sites is None else distributions(path=list(sites))
    return {plain(item.metadata["Name"]): item for item in there}


def main(site: Path | None = None) -> None:
    """Write ``locks/licences.csv``.

    Args:
        site: Folder with packages beside those of this environment.
    """
    there = {**installed(), **(installed([str(site)]) if site else {})}
    before = {item.name: item for item in read_table()} if TABLE.is_file() else {}
    rows = []
    for name, version in sorted(locked().items()):
        found = there.get(name)
        if found is not None and found.version.partition("+")[0] == version:
            rows.append(Licensed(name, version, stated_licence(found)))
        elif name in before and before[name].version == version:
            rows.append(before[name])
        else:
            rows.append(Licensed(name, version, ""))
            print(f"{name}=={version} is not installed: its licence is yet to be listed")
    with TABLE.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(("name", "version", "licence"))
        writer.writerows((item.name, item.version, item.licence) for item in rows)
    print(f"{len(rows)} packages, {sum(not item.licence for item in rows)} of which state no licence by name")


if __name__ == "__main__":
    tyro.cli(main)
