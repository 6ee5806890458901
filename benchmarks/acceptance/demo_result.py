"""What clean runs of the demo reached, as one small result file: the median of the runs and how far they lie apart.

for i in 1 2 3; do git clone -q . demo-$i && make -C demo-$i demo; done     # each in a clone of its own
python -m benchmarks.acceptance.demo_result demo-*/out/demo --write          # stores benchmarks/results/demo.json
"""

import json
import os
from pathlib import Path

import numpy as np
import tyro

from benchmarks.result import RESULTS, write_result
from warehouse_sim.dataset.manifest import Manifest, read_manifest

METRICS = ("add_2pct", "add_5pct", "add_10pct", "pose_5cm_5deg", "dock_0mm", "dock_10mm", "dock_20mm")


def main(
    demos: tyro.conf.Positional[tuple[Path, ...]], estimator: str = "densefusion-pointcloud", write: bool = False
) -> None:
    """Print and store the scores of demo folders.

    Args:
        demos: Folders that runs of the demo filled, all of one recipe and seed.
        estimator: Estimator that was trained.
        write: Store the result file.
    """
    manifest = _common_manifest(demos)
    rows = [_row(demos, method, metric) for method in (estimator, f"{estimator}-icp") for metric in METRICS]
    for row in rows:
        low, high = row["interval"]
        print(f"{row['name']:44s} {row['value']:.3f}  [{low:.3f}, {high:.3f}]  {row['runs']}  n={row['n']}")
    timings = [json.loads((demo / "timing.json").read_text(encoding="utf-8")) for demo in demos]
    minutes = [round(sum(timing.values()) / 60, 1) for timing in timings]
    observations = manifest.scenes * manifest.observations_per_scene
    print(f"{observations} observations, {minutes} minutes")
    if write:
        write_result(
            RESULTS / "demo.json",
            "make demo in clean clones, then python -m benchmarks.acceptance.demo_result demo-*/out/demo --write",
            rows,
            machine={"cores": os.cpu_count(), "renderer": manifest.renderers[0]},
            data={
                "recipe": manifest.recipe["name"],
                "seed": manifest.seed,
                "scenes": manifest.scenes,
                "observations": observations,
                "split": "test: unseen scenes, ground-truth masks",
            },
            intervals="of the median run, 95 %: over scenes; runs: each by itself",
            minutes=minutes,
            seconds=timings,
        )


def _common_manifest(demos: tuple[Path, ...]) -> Manifest:
    manifests = [read_manifest(demo / "data") for demo in demos]
    if len({(item.recipe["name"], item.seed, item.scenes) for item in manifests}) != 1:
        raise SystemExit("demo_result: name at least one folder, and only folders of one recipe, seed and length")
    return manifests[0]


def _row(demos: tuple[Path, ...], method: str, metric: str) -> dict:
    files = [demo / "scores" / method / "scores.json" for demo in demos]
    scores = [json.loads(path.read_text(encoding="utf-8")) for path in files]
    totals = [item["overall"] for item in scores]
    values = [total["metrics"][metric] for total in totals]
    # The middle run itself, not a mean of two: its interval belongs to it.
    median = totals[int(np.argsort(values, kind="stable")[(len(values) - 1) // 2])]
    return {
        "name": f"{method} {metric}",
        "value": median["metrics"][metric],
        "interval": median["intervals"][metric],
        "runs": values,
        "n": _counted(scores[0], metric),
    }


def _counted(scores: dict, metric: str) -> int:
    """Return of how many ground truths a metric is a fraction; they are the same in every run."""
    total = scores["overall"]
    if not metric.startswith("dock_"):
        return int(total["gt_count"])
    margin = metric.removeprefix("dock_").removesuffix("mm")
    return int(total["dockable_count"] - scores["docking_left_out"].get(f"no room for {margin} mm", 0))


if __name__ == "__main__":
    tyro.cli(main)
