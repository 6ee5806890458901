"""Datasets and folders that many tests read, made once a run by whichever process asks first."""

import fcntl
import hashlib
import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

SMALL = """\
extends: smoke
description: One small view a scene.
scene: {observations_per_scene: 1}
sensors: {camera: {width: 204, height: 62, focal_px: 120.0}}
"""
BARE = """\
extends: small.yaml
description: One small view a scene, without the pictures, whose light takes longest.
sensors: {outputs: [depth, masks, poses]}
"""


@dataclass(frozen=True)
class Shared:
    """A folder of what all test processes of a run share. Nobody changes what is in it; who breaks files, copies."""

    root: Path

    def made(self, name: str, make: Callable[[Path], object]) -> Path:
        """Return the folder ``name``, which ``make`` has filled once; other processes wait until it is whole."""
        self.root.mkdir(exist_ok=True)
        folder, whole = self.root / name, self.root / f"{name}.whole"
        if whole.exists():
            return folder
        with (self.root / f"{name}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            try:
                if not whole.exists():
                    shutil.rmtree(folder, ignore_errors=True)  # of a try that failed
                    make(folder)
                    whole.touch()
            finally:
                # Closing alone would not free it while a process that ``make`` forked still has the file open.
                fcntl.flock(lock, fcntl.LOCK_UN)
        return folder

    @property
    def small(self) -> Path:
        """The file of a recipe for tests that look at runs, files and processes."""
        return self._recipes() / "small.yaml"

    @property
    def bare(self) -> Path:
        """The file of the same one without colour, which BOP holds: for tests of runs and processes alone."""
        return self._recipes() / "bare.yaml"

    def _recipes(self) -> Path:
        def write(folder: Path) -> None:
            folder.mkdir()
            (folder / "small.yaml").write_text(SMALL)
            (folder / "bare.yaml").write_text(BARE)

        return self.made("recipes", write)

    def dataset(self, recipe: Any = "smoke", **config: Any) -> Path:
        """Return the dataset that ``generate`` makes.

        Args:
            recipe: A recipe, a shipped one's name, or a file.
            config: Fields of ``GenerateConfig``.
        """
        # What makes scenes takes seconds to import, and most tests make none.
        from warehouse_sim.config import to_mapping
        from warehouse_sim.generation.generate import generate
        from warehouse_sim.generation.plan import GenerateConfig
        from warehouse_sim.generation.recipe import load_recipe

        recipe, given = load_recipe(str(recipe)) if isinstance(recipe, str | Path) else recipe, GenerateConfig(**config)
        key = json.dumps([to_mapping(recipe), to_mapping(given)], sort_keys=True, default=str)
        name = f"{recipe.name}-{hashlib.sha256(key.encode()).hexdigest()[:12]}"
        return self.made(name, lambda folder: generate(recipe, folder, given))


def hashes(root: Path) -> dict[str, str]:
    """Return the content hash of every file under ``root`` by relative path."""
    files = sorted(path for path in root.rglob("*") if path.is_file())
    return {str(path.relative_to(root)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}
