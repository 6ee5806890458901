"""The card as Markdown: it reads in any editor, and shows its pictures where Markdown is shown."""

import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from warehouse_sim.dataset.card.tally import BINS, Tally, bin_names, text_bars
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.output import write_bytes

OWN = "Apache-2.0"
"""Of this package, its textures and photometric files, and of what it makes of them alone."""
OWNERS = "as its owner says"
"""Of what users brought: only they know."""
DATA, TEXTURES = "data", "textures"


def data_licences(textures: str, brought: Iterable[str], plugins: Iterable[str]) -> dict[str, str]:
    """Return what is licensed how in a generated dataset.

    Args:
        textures: Licence of the shipped textures.
        brought: Files of the user's own that the recipe names: objects, goods, photometry.
        plugins: Third-party packages that took part.
    """
    others = [*sorted(set(brought)), *(f"plug-in {name}" for name in sorted(plugins))]
    return {DATA: OWN, TEXTURES: textures} | dict.fromkeys(others, OWNERS)


def licence_text(licences: Mapping[str, str]) -> str:
    """Return what a card says of the licences, as Markdown."""
    if not licences:
        return "Not stated by who made it."
    others = [name for name in licences if name not in (DATA, TEXTURES)]
    lines = ["The data may be used like the package that made it.\n"] if licences.get(DATA) == OWN else []
    lines += [f"- {name}: {licence}" for name, licence in licences.items()]
    if others and DATA in licences:
        lines.append(
            "\nWhat shows things that users brought is also bound to what their owners allow; all else is under the "
            f"licence of the data, {licences[DATA]}."
        )
    return "\n".join(lines)


@dataclass(frozen=True)
class DiskUse:
    """Bytes of some folders."""

    by_folder: dict[str, int]
    """Folder -> bytes of its files, were it copied alone; what is linked within it counts once."""
    together: int
    """Bytes of all folders, where files that formats share as links count once."""


def measure(root: Path, folders: Iterable[str]) -> DiskUse:
    """Measure folders of a dataset; those that do not exist are left out.

    Args:
        root: Folder of the dataset.
        folders: Names in it.
    """
    by_folder: dict[str, int] = {}
    linked: set[tuple[int, int]] = set()
    together = 0
    for name in (name for name in folders if (root / name).is_dir()):
        own: set[tuple[int, int]] = set()
        by_folder[name] = 0
        for status in _files(root / name):
            key = status.st_dev, status.st_ino
            by_folder[name] += 0 if key in own else status.st_size
            together += 0 if key in own or key in linked else status.st_size
            if status.st_nlink > 1:
                own.add(key)
        linked |= own
    return DiskUse(by_folder, together)


def _files(folder: Path) -> Iterator[os.stat_result]:
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.is_dir(follow_symlinks=False):
                yield from _files(Path(entry.path))
            elif entry.is_file(follow_symlinks=False):
                yield entry.stat(follow_symlinks=False)


_TITLES = {
    "visible_fraction": "Visible fraction of labels",
    "distance": "Distance from the camera to labels (m)",
    "lux": "Illuminance on labels (lx)",
}
_GIGA = 1e9


@dataclass(frozen=True)
class Card:
    """All that a card says, before it is text."""

    name: str
    description: str
    tally: Tally
    splits: Mapping[str, tuple[int, int]]
    """Split -> number of scenes and of observations."""
    disk: DiskUse
    licences: Mapping[str, str]
    facts: Mapping[str, str]
    """What it is, each fact by its name: sensors, seed, ..."""
    again: str
    """Command that makes it again, one or several lines."""
    versions: Mapping[str, str] = field(default_factory=dict)
    limits: Mapping[str, Sequence[str]] = field(default_factory=dict)
    """Heading -> statements."""
    sheet: str | None = None
    """Path of the thumbnails in the dataset."""


def card_text(card: Card) -> str:
    """Return the card."""
    sections = [f"# {card.name}", card.description, f"![thumbnails]({card.sheet})" if card.sheet else ""]
    sections += ["## What it is", _table(["", ""], card.facts.items()), _splits(card)]
    sections += ["## What is in it", _classes(card.tally), *_histograms(card.tally)]
    sections += ["## How large it is", _disk(card)]
    sections += ["## Licence", licence_text(card.licences)]
    sections += ["## How to make it again", f"```\n{card.again}\n```"]
    if card.versions:
        sections.append(_table(["package", "version"], card.versions.items()))
    if card.limits:
        sections.append("## Limits")
    for heading, statements in card.limits.items():
        sections += [f"### {heading}", "\n".join(f"- {item}" for item in statements)]
    return "\n\n".join(part.strip("\n") for part in sections if part) + "\n"


def write_card(root: Path, card: Card) -> None:
    """Write the card of the dataset in ``root``.

    Raises:
        OutputError: It cannot be written.
    """
    write_bytes(DatasetLayout(root).readme, card_text(card).encode("utf-8"), durable=True)


def _observations(card: Card) -> int:
    return sum(observations for _, observations in card.splits.values())


def _splits(card: Card) -> str:
    rows = [(name, f"{scenes:,}", f"{observations:,}") for name, (scenes, observations) in card.splits.items()]
    scenes = sum(scenes for scenes, _ in card.splits.values())
    return _table(["split", "scenes", "observations"], [*rows, ("all", f"{scenes:,}", f"{_observations(card):,}")])


def _classes(tally: Tally) -> str:
    """Return what was placed and seen of each class: objects, and how many of them differ in shape or paint."""
    head = ["class", "labels", "objects", "seen", "CAD geometries", "meshes", "of them worn", "looks", "looks seen"]
    by_class: dict[str, list] = {}
    for look, count in tally.looks.items():
        by_class.setdefault(look.class_name, []).append((look, count))
    rows = []
    for name in sorted(by_class, key=lambda name: (-sum(count.labels for _, count in by_class[name]), name)):
        found = by_class[name]
        rows.append(
            (
                name,
                *(f"{sum(getattr(count, key) for _, count in found):,}" for key in ("labels", "placed", "seen")),
                f"{len({look.obj_id for look, _ in found}):,}",
                f"{len({look.mesh for look, _ in found}):,}",
                f"{len({look.mesh for look, _ in found if look.damaged}):,}",
                f"{len({look.look for look, _ in found}):,}",
                f"{len({look.look for look, count in found if count.seen or count.labels}):,}",
            )
        )
    note = (
        "*Labels*: of objects in images. *Seen*: objects with a pixel in any image. *Meshes* differ in shape, *looks* "
        "in shape or paint; both are distinguished by their data, whatever their names."
    )
    return f"{_table(head, rows)}\n\n{note}"


def _histograms(tally: Tally) -> list[str]:
    labels: Counter[str] = Counter()
    for look, count in tally.looks.items():
        labels[look.class_name] += count.labels
    parts = [_bars("Labels by class", {name: count for name, count in labels.most_common() if count})]
    for name, counts in tally.bins.items():
        if sum(counts):
            names = bin_names(BINS[name], last_open=name != "visible_fraction")
            parts.append(_bars(_TITLES[name], dict(zip(names, counts, strict=True))))
    return parts


def _bars(title: str, counts: Mapping[str, int]) -> str:
    return f"{title}:\n\n```\n" + "\n".join(text_bars(counts)) + "\n```" if counts else ""


def _disk(card: Card) -> str:
    observations = _observations(card)
    rows = [_disk_row(f"`{name}/`", size, observations) for name, size in card.disk.by_folder.items()]
    together = _disk_row("together, files that formats share counted once", card.disk.together, observations)
    return _table(["", "MB", "kB an observation", "GB for 1,000 observations"], [*rows, together])


def _disk_row(name: str, size: int, observations: int) -> tuple[str, ...]:
    each = size / max(observations, 1)
    return name, f"{size / 1e6:,.1f}", f"{each / 1e3:,.1f}", f"{1000 * each / _GIGA:.3f}"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(_cell(cell) for cell in line)} |" for line in lines)


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")
