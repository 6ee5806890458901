"""How an approach ends: the pallet that is driven up to, by single shots and tracked.

    python -m benchmarks.estimators.approaches DATA POSES.csv --write

DATA is a dataset of the recipe ``approach``, POSES.csv what ``warehouse-sim predict`` gives for it without ``--track``.
"""

from pathlib import Path

import numpy as np
import tyro

from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim.dataset.reader import DatasetReader, TargetRecord
from warehouse_sim.dataset.results import predictions
from warehouse_sim.dataset.stored.scene_record import read_scene_record
from warehouse_sim.estimators.tracking.belief import difference
from warehouse_sim.estimators.tracking.drives import drives, tracked
from warehouse_sim.schema import PoseEstimate


def error(reader: DatasetReader, target: TargetRecord, found: list[PoseEstimate]) -> tuple[float, float, float]:
    """Return what the estimate nearest to a target is off by (m, deg), and what it says (m); infinite where none is."""
    group = target.info(reader.objects).symmetry
    steps = [
        (difference(item.T_camera_object, T), item)
        for item in found
        if item.obj_id == target.obj_id
        for T in group.equivalents(target.T_camera_object)
    ]
    if not steps:
        return np.inf, np.inf, np.inf
    best, item = min(steps, key=lambda pair: float(np.linalg.norm(pair[0][:3]) + np.linalg.norm(pair[0][3:])))
    nominal = np.inf if item.covariance is None else float(np.sqrt(np.trace(item.covariance[:3, :3])))
    return float(np.linalg.norm(best[:3])), float(np.degrees(np.linalg.norm(best[3:]))), nominal


def measured(reader: DatasetReader, split: str, ways: dict[str, list[PoseEstimate]]) -> list[dict]:
    """Return one row for each drive: errors of its aimed-at pallet in each image, by the way of estimation."""
    images, rows = {(image.scene_id, image.image_id): image for image in reader.images(split)}, []
    for drive in drives(reader, split):
        aimed = read_scene_record(reader.root, drive[0].scene_id).observations[drive[0].image_id].target
        row: dict = {"name": f"scene {drive[0].scene_id}"}
        for way, estimates in ways.items():
            errors = []
            for view in drive:
                key = view.scene_id, view.image_id
                target = next((item for item in images[key].targets if item.instance_id == aimed), None)
                if target is not None:
                    mine = [item for item in estimates if (item.scene_id, item.image_id) == key]
                    errors.append(error(reader, target, mine))
            mm, deg, nominal = np.array(errors).T * [[1e3], [1.0], [1e3]]
            row[way] = {
                "last_mm": mm[-1], "last_deg": deg[-1], "best_mm": mm.min(), "best_deg": deg[mm.argmin()],
                "median_mm": float(np.median(mm)), "median_deg": float(np.median(deg)), "worst_mm": mm.max(),
                "surest_mm": mm[nominal.argmin()],
            }  # fmt: skip
        row["value"], row["unit"] = row["tracked"]["last_mm"], "mm off in the last image, tracked"
        rows.append(rounded(row))
    return rows


def main(
    data: tyro.conf.Positional[Path], poses: tyro.conf.Positional[Path], split: str = "test", write: bool = False
) -> None:
    """Compare single shots with tracks.

    Args:
        data: Dataset with drives.
        poses: Estimates with covariances.
        split: Which images.
        write: Store the result.
    """
    reader, single = DatasetReader(data), predictions.read(poses)
    rows = measured(reader, split, {"single": single, "tracked": tracked(reader, split, single)})
    for row in rows:
        print(
            "|", row["name"], *(f"| {value:.1f}" for way in ("single", "tracked") for value in row[way].values()), "|"
        )
    if write:
        seed = reader.manifest.seed if reader.manifest else None
        command = "python -m benchmarks.estimators.approaches DATA POSES.csv --write"
        write_result(RESULTS / "approaches.json", command, rows, data={"recipe": reader.name, "seed": seed})


if __name__ == "__main__":
    tyro.cli(main)
