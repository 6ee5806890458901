import hashlib
import json
from pathlib import Path

import cv2
import pytest

from warehouse_sim.catalog.bake import bake, pixels_hash
from warehouse_sim.catalog.textures import DETAILS, TEXTURES
from warehouse_sim.errors import WarehouseSimError
from warehouse_sim.resources import data_folder


def entries() -> dict[str, dict[str, str]]:
    manifest = json.loads((data_folder("assets") / "manifest.json").read_text())
    return {entry["path"]: entry for entry in manifest["files"]}


@pytest.mark.slow
def test_shipped_textures_are_what_the_command_bakes(tmp_path: Path) -> None:
    bake(tmp_path)
    kinds = ("albedo", "normal", "roughness")
    assert sorted(entries()) == sorted(
        f"textures/{name}/{kind}.png" for name in [*TEXTURES, *DETAILS] for kind in kinds
    )
    for path, entry in entries().items():
        baked, shipped = (
            cv2.imread(str(folder / path), cv2.IMREAD_UNCHANGED)[..., ::-1]
            if path.endswith("normal.png")
            else cv2.imread(str(folder / path), cv2.IMREAD_UNCHANGED)
            for folder in (tmp_path, data_folder("assets"))
        )
        assert pixels_hash(baked) == pixels_hash(shipped) == entry["sha256_pixels"]
        assert hashlib.sha256((data_folder("assets") / path).read_bytes()).hexdigest() == entry["sha256"]
        assert entry["licence"]
        assert entry["command"].startswith("python -m warehouse_sim")


def test_assets_stay_small_and_hold_nothing_else() -> None:
    files = {path for path in data_folder("assets").rglob("*") if path.is_file()}
    assert sum(path.stat().st_size for path in files) < 19_000_000
    listed = {data_folder("assets") / path for path in entries()}
    assert files - listed == {data_folder("assets") / "manifest.json"}


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(WarehouseSimError, match="file"):
        bake(tmp_path / "file")
