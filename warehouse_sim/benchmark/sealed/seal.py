"""The sealed half of a frozen set: one file with all that the public folder lacks, known by its SHA-256."""

import json
import shutil
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from warehouse_sim.benchmark.kept import file_digest
from warehouse_sim.benchmark.sealed.public import IMAGES, SPLIT
from warehouse_sim.config import from_mapping
from warehouse_sim.dataset.files.checksums import file_sum
from warehouse_sim.dataset.formats.bop import bop_layout
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.errors import InputError
from warehouse_sim.output import whole_file
from warehouse_sim.resources import data_folder

ENDING = ".sealed"
SUMS = "sealed.sha256"
"""Beside the suites: the hashes of sealed files, as sha256sum writes them."""
_FACTS = "set.json"
_FORMAT = 1


@dataclass(frozen=True)
class SetFacts:
    """What a sealed file says of itself."""

    name: str
    """Such as ``warehouses-v1``."""
    suite: str
    """Whose metrics and groups count."""
    data: dict[str, str]
    """SHA-256 of the folder of each dataset in the public half."""
    seeds: dict[str, int]
    """Of each, from the system's randomness; written nowhere else."""
    format: int = _FORMAT

    def __post_init__(self) -> None:
        if self.format != _FORMAT:
            raise ValueError(f"format must be {_FORMAT}, found {self.format}")


def write_sealed(path: Path, facts: SetFacts, roots: Mapping[str, Path]) -> str:
    """Write a sealed file and return its SHA-256.

    Args:
        path: The file.
        facts: What it says of itself.
        roots: Folder of each dataset, with its labels.
    """
    with whole_file(path) as file, zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(_FACTS, json.dumps(asdict(facts)))
        for name, root in roots.items():
            for member in _truth(root):
                archive.write(member, f"{name}/{member.relative_to(root).as_posix()}")
    return file_sum(path)


def require_sealed(path: Path, sums: Path | None = None) -> None:
    """Check that a sealed file is the one whose hash is published.

    Args:
        path: The file.
        sums: List of hashes; the shipped one by default.

    Raises:
        InputError: There is no such file, the list lacks its name, or it is another one.
    """
    if not path.is_file():
        raise InputError(f"{path}: there is no such sealed file; docs/benchmark.md says who holds it")
    sums = sums or data_folder("benchmarks") / "suites" / SUMS
    if not sums.is_file():
        raise InputError(f"{sums}: there is no such list of hashes")
    lines = (line.split() for line in sums.read_text(encoding="utf-8").splitlines())
    listed = {words[1]: words[0] for words in lines if len(words) == 2}
    if path.name not in listed:
        raise InputError(
            f"{path}: {sums.name} lists no {path.name}; name the list that came with the set with --sums, "
            f"or keep the file's name: {', '.join(sorted(listed)) or 'none is listed'}"
        )
    found = file_sum(path)
    if found != listed[path.name]:
        raise InputError(
            f"{path}: its SHA-256 is {found}, {sums.name} has {listed[path.name]}: it is another set or was changed"
        )


def read_facts(path: Path) -> SetFacts:
    """Return what a sealed file says of itself.

    Raises:
        InputError: It is none.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            plain = json.loads(archive.read(_FACTS))
    except (OSError, KeyError, ValueError, zipfile.BadZipFile) as problem:
        raise InputError(f"{path}: is no sealed set ({problem})") from problem
    return from_mapping(SetFacts, plain, str(path))


@contextmanager
def opened(path: Path) -> Iterator[Path]:
    """Unpack what scores need, all but masks, for as long as the block takes; datasets are folders of what it yields.

    It goes into the system's temporary folder, and from there when the block ends.
    """
    with TemporaryDirectory(prefix="sealed-") as folder, zipfile.ZipFile(path) as archive:
        archive.extractall(folder, [name for name in archive.namelist() if not name.endswith(".png")])
        yield Path(folder)


def unsealed(path: Path, public: Path, out: Path) -> dict[str, Path]:
    """Put both halves of a set together again, and return the folder of each dataset.

    Args:
        path: The sealed file.
        public: The public folder.
        out: Where the datasets go; those that are whole there stay.

    Raises:
        InputError: The public folder is of another set, or was changed.
    """
    facts, roots = read_facts(path), dict[str, Path]()
    for name, digest in facts.data.items():
        if not (public / name).is_dir() or file_digest(public / name) != digest:
            raise InputError(f"{public / name}: is not what {facts.name} was sealed with; take the folder as published")
    with zipfile.ZipFile(path) as archive:
        for name in facts.data:
            roots[name] = root = out / name
            if DatasetLayout(root).manifest.is_file():
                continue
            members = [item for item in archive.namelist() if item.startswith(f"{name}/")]
            last = f"{name}/{DatasetLayout(Path()).manifest}"  # it says that the dataset is complete
            archive.extractall(out, [item for item in members if item != last])
            scenes = bop_layout(root).root / SPLIT
            for kind in IMAGES:
                for scene in sorted(scenes.iterdir()):
                    shutil.copytree(public / name / SPLIT / scene.name / kind, scene / kind, dirs_exist_ok=True)
            archive.extract(last, out)
    return roots


def _truth(root: Path) -> Iterator[Path]:
    """Yield the files of a dataset that scores, and references that read labels, need."""
    layout = DatasetLayout(root)
    yield layout.manifest
    yield layout.objects
    yield from sorted(layout.scenes.iterdir())
    yield from sorted(layout.damaged.glob("*"))
    left_out = (*IMAGES, "mask")  # amodal masks decide no score
    for path in sorted(bop_layout(root).root.rglob("*")):
        if path.is_file() and path.parent.name not in left_out:
            yield path
