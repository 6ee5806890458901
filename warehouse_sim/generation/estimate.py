"""What a dataset will cost, by one scene of it that is made in a temporary folder and thrown away."""

import math
import shutil
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path

from warehouse_sim.dataset.card.text import DiskUse, measure
from warehouse_sim.dataset.shards.shard import Shard
from warehouse_sim.dataset.stored.scene_record import SceneRecord, read_scene_record
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.schema.labels import FREE

_GB = 1e9


@dataclass(frozen=True)
class Estimate:
    """Cost and contents of a dataset, as its first scene has them."""

    scenes: int
    """To be made: of the dataset, or of its shard."""
    observations_per_scene: int
    cpu_s: float
    """CPU time of a scene (s)."""
    wall_s: float
    """How long a scene takes (s)."""
    workers: int
    gb_by_folder: dict[str, float]
    """Of the dataset, by folder: its formats, and records and surfaces that lie beside them (GB)."""
    gb: float
    """Of all of them, where files that formats share count once (GB)."""
    targets: float
    """Labelled targets an observation."""
    dockable: float
    """Those of them that stand in no stack and have a face that a truck can take them by, an observation."""
    free_gb: float
    """Left on the disk of the output (GB)."""

    @property
    def cpu_hours(self) -> float:
        """CPU time of the dataset (h)."""
        return self.scenes * self.cpu_s / 3600.0

    @property
    def wall_hours(self) -> float:
        """How long the dataset takes if each worker has a processor (h)."""
        return math.ceil(self.scenes / self.workers) * self.wall_s / 3600.0


def estimate(recipe: Recipe, config: GenerateConfig, out: Path) -> Estimate:
    """Make the first scene of a dataset, or of its shard, and return what the whole will be.

    Args:
        recipe: Where scenes are sampled from.
        config: As for ``generate``.
        out: Where the dataset would lie; nothing is written there.

    Raises:
        WarehouseSimError: As ``generate``.
    """
    total = config.scenes or recipe.scenes
    shard = config.shard or Shard(0, 1)
    first = Shard(shard.index, total)
    # Which scene comes into which split costs nothing here, and would have all of them measured.
    plain = replace(recipe, split=replace(recipe.split, stratify=()))
    alone = replace(config, shard=first, workers=1, resume=False, overwrite=False, skip_failed=False, max_gb=None)
    with tempfile.TemporaryDirectory(prefix="warehouse-sim-plan-") as folder:
        root, moments = Path(folder) / "scene", list[tuple[float, float, DiskUse]]()

        def note(done: int, of: int) -> None:
            moments.append((time.process_time(), time.monotonic(), _use(root)))

        manifest = generate(plain, root, alone, note)
        record = read_scene_record(root, first.index)
    (cpu_0, wall_0, before), (cpu_1, wall_1, after) = moments[0], moments[-1]
    scenes, each = len(shard.scenes(total)), manifest.observations_per_scene
    targets, dockable = _targets(record)
    return Estimate(
        scenes=scenes,
        observations_per_scene=each,
        cpu_s=cpu_1 - cpu_0,
        wall_s=wall_1 - wall_0,
        workers=config.workers,
        gb_by_folder={
            name: _grown(before.by_folder.get(name, 0), size, scenes) for name, size in after.by_folder.items()
        },
        gb=_grown(before.together, after.together, scenes),
        targets=targets / each,
        dockable=dockable / each,
        free_gb=shutil.disk_usage(_existing(out)).free / _GB,
    )


def _use(root: Path) -> DiskUse:
    return measure(root, sorted(path.name for path in root.iterdir() if path.is_dir() and path.name != "card"))


def _grown(before: int, after: int, scenes: int) -> float:
    return (before + scenes * (after - before)) / _GB


def _targets(record: SceneRecord) -> tuple[int, int]:
    """Return how many targets all observations show, and how many of them can be docked at."""
    shown = [target.instance_id for item in record.observations for target in item.targets]
    free = {
        item.instance_id
        for item in record.objects
        if item.accessibility is not None and not item.stacked and FREE in item.accessibility.faces.values()
    }
    return len(shown), sum(number in free for number in shown)


def _existing(path: Path) -> Path:
    return next(folder for folder in (path.absolute(), *path.absolute().parents) if folder.exists())
