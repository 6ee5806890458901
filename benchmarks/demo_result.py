"""What a demo reached, as one small result file.

make demo && python benchmarks/demo_result.py --write      # stores benchmarks/results/demo.json
"""

import json
import os
from pathlib import Path

import tyro

from warehouse_sim.dataset.manifest import read_manifest

RESULT = Path(__file__).parent / "results" / "demo.json"
METRICS = ("add_2pct", "add_5pct", "add_10pct", "pose_5cm_5deg", "dock_0mm", "dock_10mm", "dock_20mm")


def main(demo: Path = Path("out/demo"), estimator: str = "densefusion-pointcloud", write: bool = False) -> None:
    """Print and store the scores of a demo folder.

    Args:
        demo: Folder that the demo filled.
        estimator: Estimator that was trained.
        write: Store the result file.
    """
    manifest = read_manifest(demo / "data")
    timing = json.loads((demo / "timing.json").read_text(encoding="utf-8"))
    rows = []
    for method in (estimator, f"{estimator}-icp"):
        scores = json.loads((demo / "scores" / method / "scores.json").read_text(encoding="utf-8"))
        total = scores["overall"]
        for metric in METRICS:
            rows.append(
                {
                    "name": f"{method} {metric}",
                    "value": total["metrics"][metric],
                    "interval": total["intervals"][metric],
                    "n": total["gt_count"],
                }
            )
    for row in rows:
        low, high = row["interval"]
        print(f"{row['name']:52s} {row['value']:.3f}  [{low:.3f}, {high:.3f}]  n={row['n']}")
    print(f"{manifest.scenes * manifest.observations_per_scene} observations, {sum(timing.values()) / 60:.1f} minutes")
    if write:
        result = {
            "machine": {"cores": os.cpu_count(), "renderer": manifest.renderers[0]},
            "command": "make demo && python benchmarks/demo_result.py --write",
            "data": {
                "recipe": manifest.recipe["name"],
                "seed": manifest.seed,
                "scenes": manifest.scenes,
                "observations": manifest.scenes * manifest.observations_per_scene,
                "split": "test: unseen scenes, ground-truth masks",
            },
            "seconds": timing,
            "rows": rows,
        }
        RESULT.write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")
        print(f"output: {RESULT}")


if __name__ == "__main__":
    tyro.cli(main)
