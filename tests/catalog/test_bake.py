import hashlib
import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from warehouse_sim.catalog.bake import bake, pixels_hash
from warehouse_sim.catalog.textures import NEUTRAL, SIZE, TEXTURES, paint
from warehouse_sim.errors import WarehouseSimError
from warehouse_sim.resources import data_folder


def entries() -> dict[str, dict[str, str]]:
    manifest = json.loads((data_folder("assets") / "manifest.json").read_text())
    return {entry["path"]: entry for entry in manifest["files"]}


def test_shipped_textures_are_what_the_command_bakes(tmp_path: Path) -> None:
    bake(tmp_path)
    assert sorted(entries()) == sorted(f"textures/{name}.png" for name in TEXTURES)
    for path, entry in entries().items():
        baked, shipped = (
            cv2.imread(str(folder / path), cv2.IMREAD_UNCHANGED) for folder in (tmp_path, data_folder("assets"))
        )
        assert pixels_hash(baked) == pixels_hash(shipped) == entry["sha256_pixels"]
        assert hashlib.sha256((data_folder("assets") / path).read_bytes()).hexdigest() == entry["sha256"]
        assert entry["licence"]
        assert entry["command"].startswith("python -m warehouse_sim")


def test_assets_stay_small() -> None:
    assert sum(path.stat().st_size for path in data_folder("assets").rglob("*") if path.is_file()) < 1_000_000


@pytest.mark.parametrize("name", TEXTURES)
def test_a_texture_is_neutral_on_average_and_varies(name: str) -> None:
    pixels = paint(name)
    assert pixels.shape == (SIZE, SIZE)
    assert pixels.mean() == pytest.approx(NEUTRAL, abs=0.5)
    assert 2.0 < pixels.std() < 30.0


@pytest.mark.parametrize("name", TEXTURES)
@pytest.mark.parametrize("axis", [0, 1])
def test_a_texture_tiles_without_a_seam(name: str, axis: int) -> None:
    pixels = paint(name).astype(float)
    steps = np.abs(np.roll(pixels, -1, axis=axis) - pixels).mean(axis=1 - axis)
    assert steps[-1] <= steps[:-1].max()


def test_the_grain_of_wood_runs_along_u() -> None:
    pixels = paint("wood").astype(float)
    along_u, along_v = (np.abs(np.diff(pixels, axis=axis)).mean() for axis in (1, 0))
    assert along_v > 3.0 * along_u


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(WarehouseSimError, match="file"):
        bake(tmp_path / "file")
