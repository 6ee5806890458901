"""What the public folder of a frozen set says of itself: a datasheet, and Croissant metadata."""

import json
from collections.abc import Iterator
from pathlib import Path

from warehouse_sim.benchmark.sealed.public import SPLIT
from warehouse_sim.dataset.card.croissant import FILE, About, described, write_metadata
from warehouse_sim.dataset.formats.bop import BopLayout
from warehouse_sim.output import write_bytes
from warehouse_sim.version import __version__

README = "README.md"
_README = """# {name}

Test images of the suite `{suite}`: a BOP folder for each of {count} layouts, with images, calibration (of the world
only tilt and height), CAD models and lists of targets. The ground truth is in `{sealed}`, SHA-256 `{digest}`.

    warehouse-sim predict ESTIMATOR --data {name}/LAYOUT --out mine/LAYOUT.csv --detections DETECTOR+SEGMENTER
    warehouse-sim evaluate mine --sealed {sealed} --out scores

| layout | scenes | images | targets |
|---|---|---|---|
{rows}

## Datasheet

- **Why**: to compare methods that locate pallets in 6D, on halls that nobody trained or tuned on.
- **What**: synthetic colour and depth images. No person, place or brand is real. Targets are pallets of which at
  least a tenth shows.
- **How**: recipes of the same names of warehouse_sim {version}, each with the cameras and noise that it states. What
  is sampled comes from the system's randomness, and nobody chose among sets.
- **What is left out**: the ground truth.
- **Use**: test alone. Train and tune on data of your own making: `warehouse-sim generate LAYOUT`. Scores say nothing
  of a real site.
- **Upkeep**: it never changes. A mistake leads to a set of the next number, on which all are evaluated again; the
  holder of `{sealed}` keeps a log of all evaluations beside it.
- **Licence**: {licence}
"""


def write_about(folder: Path, suite: str, sealed: str, digest: str, licence: str) -> None:
    """Write the datasheet and ``croissant.json``.

    Args:
        folder: The public folder; its name is the set's unless ``sealed`` says another.
        suite: Name of the suite.
        sealed: Name of the sealed file.
        digest: Its SHA-256.
        licence: Of the data.
    """
    name, layouts = Path(sealed).stem, sorted(path for path in folder.iterdir() if path.is_dir())
    rows = "\n".join(_rows(layouts))
    text = _README.format(
        name=name,
        suite=suite,
        count=len(layouts),
        sealed=sealed,
        digest=digest,
        rows=rows,
        version=__version__,
        licence=licence,
    )
    write_bytes(folder / README, text.encode("utf-8"))
    sealed_half = f"the ground truth is sealed, SHA-256 {digest}"
    about = About(
        name=name,
        description=f"Test images of {len(layouts)} synthetic warehouses; {sealed_half}.",
        cite=f"warehouse_sim {__version__}: {name}",
        keywords=("pallet", "6D", "BOP", "RGB-D"),
        licence=licence,
    )
    write_metadata(described(folder, ".", about), folder / FILE)


def _rows(layouts: list[Path]) -> Iterator[str]:
    for root in layouts:
        layout = BopLayout(root)
        targets = json.loads(layout.targets(2019).read_text(encoding="utf-8"))
        scenes = sorted((layout.root / SPLIT).iterdir())
        images = sum(len(list((scene / "depth").iterdir())) for scene in scenes)
        count = sum(target["inst_count"] for target in targets)
        yield f"| `{root.name}` | {len(scenes)} | {images} | {count} |"
