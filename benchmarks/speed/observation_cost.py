"""CPU-seconds of one observation of a recipe, stage by stage: RGB-D, ids, LiDAR, labels, KITTI and BOP files.

    python benchmarks/speed/observation_cost.py            # prints the table
    python benchmarks/speed/observation_cost.py --write    # and stores benchmarks/results/observation_cost.json

CPU time of this process and all its threads, so a busy machine does not change it much. Sampling and settling are
shared by a scene's observations and counted in full. The median over scenes is reported.
"""

import json
import platform
import statistics
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import tyro

from warehouse_sim.config import to_mapping
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.generation import observe
from warehouse_sim.generation.generate import GenerateConfig, make_manifest, target_models
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import settled_scene
from warehouse_sim.render import open_renderer

RESULT = Path(__file__).parents[1] / "results" / "observation_cost.json"


class StageClock:
    """Sums CPU time by stage; a nested stage is taken out of the one around it."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = defaultdict(float)
        self._inner = [0.0]

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Count the block under ``name``."""
        start = time.process_time()
        self._inner.append(0.0)
        try:
            yield
        finally:
            elapsed = time.process_time() - start
            self.seconds[name] += elapsed - self._inner.pop()
            self._inner[-1] += elapsed

    def wrap(self, function, name):
        """Return ``function``, counted under ``name``."""

        def counted(*arguments, **keywords):
            with self.stage(name):
                return function(*arguments, **keywords)

        return counted


def measure_scene(recipe, store: DatasetStore, renderer, scene_index: int) -> dict[str, float]:
    """Make one scene and return CPU-seconds an observation by stage."""
    clock = StageClock()
    stages = {"read_rgbd": "depth and image noise", "scan": "LiDAR", "annotate": "labels", "RayCaster": "LiDAR"}
    originals = {name: getattr(observe, name) for name in stages}
    for name, stage in stages.items():
        setattr(observe, name, clock.wrap(originals[name], stage))
    methods = {"load": "shadow maps and upload", "render": "RGB, depth, ids", "silhouettes": "silhouettes"}
    for name, stage in methods.items():
        setattr(renderer, name, clock.wrap(getattr(type(renderer), name).__get__(renderer), stage))
    try:
        with clock.stage("sample and settle"):
            scene, report = settled_scene(recipe, store.manifest.seed, scene_index)
        with clock.stage("encode and write KITTI and BOP"):
            observations = observe.observe_scene(scene, recipe.sensors, renderer)
            store.write_scene(scene, observations, to_mapping(report), renderer.description)
    finally:
        for name, function in originals.items():
            setattr(observe, name, function)
        for name in methods:
            delattr(renderer, name)
    return {stage: seconds / len(scene.viewpoints) for stage, seconds in clock.seconds.items()}


def main(recipe: str = "demo", scenes: int = 3, seed: int = 0, write: bool = False) -> None:
    """Measure and print.

    Args:
        recipe: Name or path of a recipe.
        scenes: Scenes to measure, after one that warms up.
        seed: Seed of the dataset.
        write: Store the result file.
    """
    loaded = load_recipe(recipe)
    with tempfile.TemporaryDirectory() as folder, open_renderer("raster") as renderer:
        store = DatasetStore(Path(folder), make_manifest(loaded, GenerateConfig(scenes=scenes + 1, seed=seed)))
        store.begin(target_models(loaded), loaded.sensors.make_camera())
        measured = [measure_scene(loaded, store, renderer, index) for index in range(scenes + 1)][1:]
        renderer_name = renderer.description
    rows = [
        {"name": stage, "ours_cpu_s": round(statistics.median(scene.get(stage, 0.0) for scene in measured), 4)}
        for stage in measured[0]
    ]
    rows.append({"name": "total", "ours_cpu_s": round(statistics.median(sum(scene.values()) for scene in measured), 4)})
    for row in rows:
        print(f"{row['name']:34s} {row['ours_cpu_s']:.3f} CPU-s")
    if write:
        result = {
            "machine": {"processor": platform.processor() or platform.machine(), "renderer": renderer_name},
            "command": "python benchmarks/speed/observation_cost.py"
            f" --recipe {recipe} --scenes {scenes} --seed {seed} --write",
            "rows": rows,
        }
        RESULT.write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")
        print(f"output: {RESULT}")


if __name__ == "__main__":
    tyro.cli(main)
