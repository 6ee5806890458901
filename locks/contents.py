"""Write the bill of materials of a release, in CycloneDX: the wheel, its weights and textures, and what it installs.

    python -m locks.contents dist/warehouse_sim-0.2.0-py3-none-any.whl --out dist/warehouse_sim.cdx.json

Licences of packages are those of ``locks/licences.csv``, versions those of the locks of ``demo``; weights and textures
are those in the wheel, with the licence of the package.
"""

import hashlib
import json
import re
import zipfile
from collections.abc import Iterator
from email.parser import Parser
from pathlib import Path
from typing import Annotated, Any

import tyro

from locks.licences import LOCKS, plain, read_table

_PIN = re.compile(r"^([A-Za-z0-9._-]+)==([^\s;\\]+)", re.MULTILINE)
_OURS = {".safetensors": "machine-learning-model", ".png": "data", ".jpg": "data", ".ies": "data"}
"""Files of the wheel that are listed one by one, and what they are."""
Component = dict[str, Any]


def bill(wheel: Path) -> dict[str, Any]:
    """Return the bill of materials of a wheel."""
    with zipfile.ZipFile(wheel) as archive:
        (metadata,) = [name for name in archive.namelist() if name.endswith(".dist-info/METADATA")]
        said = Parser().parsestr(archive.read(metadata).decode("utf-8"))
        licence = said["License-Expression"]
        files = [_file(archive, name, licence) for name in sorted(archive.namelist()) if Path(name).suffix in _OURS]
    ours = {
        "type": "application",
        "bom-ref": f"pkg:pypi/{plain(said['Name'])}@{said['Version']}",
        "name": said["Name"],
        "version": said["Version"],
        "licenses": [{"license": {"id": licence}}],
        "hashes": [{"alg": "SHA-256", "content": hashlib.sha256(wheel.read_bytes()).hexdigest()}],
    }
    return {
        "$schema": "http://cyclonedx.org/schema/bom-1.6.schema.json",
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {"component": ours},
        "components": [*files, *_packages()],
    }


def _file(archive: zipfile.ZipFile, name: str, licence: str) -> Component:
    content = archive.read(name)
    return {
        "type": _OURS[Path(name).suffix],
        "bom-ref": name,
        "name": name,
        "licenses": [{"license": {"id": licence}}],
        "hashes": [{"alg": "SHA-256", "content": hashlib.sha256(content).hexdigest()}],
    }


def _packages() -> Iterator[Component]:
    """Yield what an installation for the demo brings, with what each package says of its licence."""
    stated = {item.name: item.licence for item in read_table()}
    for lock in ("demo", "torch-cpu"):
        for name, version in _PIN.findall((LOCKS / f"{lock}.txt").read_text(encoding="utf-8")):
            reference = f"pkg:pypi/{plain(name)}@{version.partition('+')[0]}"
            yield {
                "type": "library",
                "bom-ref": reference,
                "purl": reference,
                "name": plain(name),
                "version": version,
                "licenses": [{"license": {"name": stated.get(plain(name)) or "see the package"}}],
            }


def main(wheel: Annotated[Path, tyro.conf.Positional], out: Path) -> None:
    """Write it.

    Args:
        wheel: The wheel.
        out: The JSON file.
    """
    made = bill(wheel)
    out.write_text(json.dumps(made, indent=1) + "\n", encoding="utf-8")
    print(f"output: {out}, {len(made['components'])} components")


if __name__ == "__main__":
    tyro.cli(main)
