"""``generate --on``: the scenes of a dataset on a Ray cluster, or as a job array of Slurm."""

import hashlib
import json
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from warehouse_sim.cli.console import count_progress, say
from warehouse_sim.config import to_mapping
from warehouse_sim.errors import DatasetError, InputError
from warehouse_sim.optional import require_extra
from warehouse_sim.version import __version__

if TYPE_CHECKING:
    from warehouse_sim.dataset.manifest import Manifest
    from warehouse_sim.generation.plan import GenerateConfig
    from warehouse_sim.generation.recipe import Recipe

RAY, SLURM = "ray", "slurm-array"
_CLIENT = "ray://"
_PORT = ":10001"
"""Where a head node listens for clients, by default."""


@dataclass(frozen=True)
class Elsewhere:
    """Which machines make the scenes."""

    on: str
    """"ray", "ray://HOST[:PORT]" or "slurm-array"."""
    shards: str | None
    """Where shards are stored; None = beside the dataset."""
    tasks: int
    """Of the job array."""
    workers: int
    """Processors of each task."""

    def __post_init__(self) -> None:
        if self.on not in (RAY, SLURM) and not (self.on.startswith(_CLIENT) and self.on != _CLIENT):
            raise InputError(f"--on {self.on}: must be ray, ray://HOST[:PORT] or slurm-array")
        if self.tasks < 1:
            raise InputError(f"--tasks must be at least 1, found {self.tasks}")

    @property
    def address(self) -> str | None:
        """The cluster as Ray names it; None = the one of RAY_ADDRESS or of this machine, else a new one here."""
        if not self.on.startswith(_CLIENT):
            return None
        host = self.on.removeprefix(_CLIENT)
        return self.on if ":" in host else f"{self.on}{_PORT}"

    def place(self, recipe: "Recipe", config: "GenerateConfig", out: Path) -> str:
        """Return where the shards of exactly this dataset lie: those of another one are never taken for them."""
        what = [to_mapping(recipe), config.scenes, config.seed, config.formats, config.backend, config.backend_options]
        key = hashlib.sha256(json.dumps([*what, __version__], sort_keys=True, default=str).encode()).hexdigest()[:12]
        return f"{self.shards or beside(out)}/{key}"


def beside(out: Path) -> Path:
    """Return the folder of shards that nobody named."""
    return out.absolute().with_name(f"{out.absolute().name}.shards")


def on_ray(recipe: "Recipe", config: "GenerateConfig", out: Path, where: Elsewhere) -> "Manifest":
    """Make all scenes on a Ray cluster, and merge them here.

    Raises:
        DatasetError: The folder holds something.
        MissingPackageError: Ray or fsspec is not installed.
        WorkerError: As ``generate_on_ray``.
    """
    require_extra("cluster", "for --on ray")
    from warehouse_sim.generation.ray_cluster import generate_on_ray, merge_packed

    require_empty(out, config.overwrite)
    place = where.place(recipe, config, out)
    with count_progress("scenes") as progress:
        generate_on_ray(recipe, place, config, where.address, progress)
    with count_progress("shards") as progress:
        manifest = merge_packed(place, out, progress, config.overwrite)
    if where.shards is None:
        shutil.rmtree(beside(out))
    else:
        say(f"the shards stay in {place}; remove them when nobody needs them")
    return manifest


def on_slurm(arguments: Sequence[str], recipe: "Recipe", config: "GenerateConfig", out: Path, where: Elsewhere) -> None:
    """Submit a job array that makes the shards, and a job that merges them.

    Raises:
        DatasetError: The folder holds something.
        InputError: This machine has no sbatch.
        WorkerError: Slurm did not take a job.
    """
    from warehouse_sim.generation.slurm_array import submit

    require_empty(out, config.overwrite)
    tasks = min(where.tasks, recipe.scenes if config.scenes is None else config.scenes)
    shards = Path(where.place(recipe, config, out)).absolute()
    jobs = submit(arguments, out.absolute(), shards, tasks, where.workers, config.overwrite)
    print(f"submitted: job {jobs.shards} makes {tasks} shards in {shards}, job {jobs.merge} merges them")
    print(f"output: {out}, when both are done; logs lie beside the shards")


def require_empty(out: Path, overwrite: bool) -> None:
    """Reject before the work a folder that could not be written after it."""
    if not overwrite and out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise DatasetError(f"{out}: is not empty; choose another folder, or add --overwrite")
