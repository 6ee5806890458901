"""Whether estimators dock at recorded pallet faces that are in no catalog, as they are and with gravity given.

    python -m benchmarks.estimators.faces FOLDER front-fit --write

FOLDER holds sites with labels.json, depth and masks, as the real samples beside this project have them; nothing of it
is copied. An estimator that answers with a face is taken at its word; one that answers with the pose of a catalog
pallet, which --catalog and --model name, sends the fork to that pallet's pockets.
"""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import tyro

from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim.benchmark.entrants.ways import way_of
from warehouse_sim.benchmark.recorded.entries import BASELINE, GRAVITY, MASKS, entries
from warehouse_sim.benchmark.recorded.faces import Entry, RecordedFace, read_faces
from warehouse_sim.dataset.reader import DatasetReader


def main(
    folder: tyro.conf.Positional[Path],
    methods: tyro.conf.Positional[tuple[str, ...]],
    catalog: Path | None = None,
    model: str | None = None,
    verbose: bool = False,
    write: bool = False,
) -> None:
    """Score estimators on a folder of recorded faces.

    Args:
        folder: Sites with labels.
        methods: Bundled models or run folders, perhaps with +verify, or registered estimators; the baseline is
            added.
        catalog: Dataset folder whose objects estimators are shown; none by default.
        model: Which of them the faces are said to be of; unknown by default.
        verbose: Print each frame.
        write: Store the result.
    """
    faces, rows = read_faces(folder), []
    objects = dict(DatasetReader(catalog).objects) if catalog else {}
    for method in (BASELINE, *methods):
        estimator = None if method == BASELINE else way_of(method).open(objects)
        for masks in MASKS:
            for gravity in GRAVITY:
                found = entries(estimator, objects, faces, masks, gravity, None if estimator is None else model)
                docked = sum(item is not None and item.docked for item in found)
                name = f"{method}, masks: {masks}, gravity: {gravity}"
                print(f"{name:70} {docked:3} of {len(faces)}", flush=True)
                rows.append(_row(name, method, masks, gravity, faces, found))
                if verbose:
                    _print(faces, found)
    if write:
        command = f"python -m benchmarks.estimators.faces FOLDER {' '.join(methods)} --write"
        how = "recorded faces of pallets with labels by hand, which are no part of this project"
        write_result(RESULTS / "faces.json", command, rows, data=how)


def _row(
    name: str, method: str, masks: str, gravity: str, faces: Sequence[RecordedFace], found: Sequence[Entry | None]
) -> dict:
    frames = {
        face.name: None if item is None else rounded({key: float(value) for key, value in asdict(item).items()})
        for face, item in zip(faces, found, strict=True)
    }
    docked = sum(item is not None and item.docked for item in found)
    common = {"method": method, "masks": masks, "gravity": gravity}
    return {"name": name, **common, "value": int(docked), "n": len(faces), "frames": frames}


def _print(faces: Sequence[RecordedFace], found: Sequence[Entry | None]) -> None:
    for face, item in zip(faces, found, strict=True):
        if item is None:
            print(f"  {face.name:24} no answer")
            continue
        print(
            f"  {face.name:24} {'docks' if item.docked else 'FAILS'} room {1e3 * item.clearance_side:5.0f} "
            f"{1e3 * item.clearance_up:4.0f} mm  depth {1e3 * item.depth:4.0f} lateral {1e3 * item.lateral:4.0f} "
            f"vertical {1e3 * item.vertical:4.0f} mm  yaw {item.yaw_deg:5.2f} pitch {item.pitch_deg:5.2f} "
            f"roll {item.roll_deg:5.2f} deg"
        )


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
