from pathlib import Path

import pytest

from tests.shared import Shared
from warehouse_sim.cli.main import main

RECIPE = """\
description: Two scenes of small images, to plant faults into.
extends: smoke
scenes: 2
scene: {targets: [pallet, carton]}
sensors:
  rig: dissertation
  lidar: vlp16
  outputs: [default, clean]
  camera: {width: 320, height: 240, focal_px: 240, cx: 157.3, cy: 121.6}
split: {train: 0.5, val: 0.0, test: 0.5}
"""


@pytest.fixture(scope="session")
def healthy(shared: Shared) -> Path:
    """A dataset of two scenes with four views, to read only."""

    def make(folder: Path) -> None:
        folder.mkdir()
        (folder / "planted.yaml").write_text(RECIPE)
        recipe, out = str(folder / "planted.yaml"), str(folder / "data")
        assert main(["generate", recipe, "--seed", "17", "--out", out, "--workers", "1"]) == 0

    return shared.made("planted", make) / "data"
