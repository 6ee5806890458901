"""What `convert` writes of a dataset of ours is what `generate` would have written, byte by byte where all is kept."""

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.dataset.toy import failures
from tests.shared import Shared, hashes
from warehouse_sim.dataset.convert.run import convert
from warehouse_sim.dataset.files.checksums import seal
from warehouse_sim.dataset.manifest import read_manifest, write_manifest
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import load_recipe

SAME = ("yolo", "bop_webdataset", "bop_compact", "linemod")
"""Formats of which every file must be equal; COCO's panoptic needs ids of what is no target, which no file holds."""


@pytest.mark.gl
def test_converted_files_are_those_that_are_generated(shared: Shared, tmp_path: Path) -> None:
    pytest.importorskip("mcap")
    recipe = load_recipe(str(shared.small))
    # Which key points are hidden follows from the true depth, which is stored with the clean images.
    recipe = replace(recipe, sensors=replace(recipe.sensors, outputs=("default", "clean")))
    config = GenerateConfig(scenes=3, seed=21, formats=("kitti", "bop", "coco", *SAME), workers=1)
    generate(recipe, tmp_path / "at_once", config)
    for name in ("scenes", "readings", "bop", "kitti"):
        shutil.copytree(tmp_path / "at_once" / name, tmp_path / "first" / name)
    shutil.copy(tmp_path / "at_once/objects.json", tmp_path / "first")
    manifest = replace(read_manifest(tmp_path / "at_once"), formats=("kitti", "bop"))
    write_manifest(tmp_path / "first/manifest.json", replace(manifest, checksums=seal(tmp_path / "first")))
    convert(tmp_path / "first", tmp_path / "then", ("coco", "mcap", "ply", *SAME))
    for name in SAME:
        assert hashes(tmp_path / "then" / name) == hashes(tmp_path / "at_once" / name), name
    for split in ("train", "val", "test"):
        table = f"coco/annotations/instances_{split}.json"
        then, at_once = (json.loads((tmp_path / name / table).read_text()) for name in ("then", "at_once"))
        assert rounded(then) == rounded(at_once)  # poses go through millimetres
    assert failures(tmp_path / "then") == {}
    image = next((tmp_path / "then" / "linemod").rglob("rgb/*.png"))
    assert image.stat().st_nlink > 2  # linked, not copied


def rounded(data: Any) -> Any:
    if isinstance(data, dict):
        return {key: rounded(item) for key, item in data.items()}
    if isinstance(data, list):
        return [rounded(item) for item in data]
    return round(data, 9) if isinstance(data, float) else data
