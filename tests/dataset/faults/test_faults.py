"""Faults planted at random places of a rendered dataset: each is found, by the check and in the words of the table."""

import zlib
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.faults.folder import Folder, linked_copy
from tests.dataset.faults.table import FAULTS, Fault
from warehouse_sim.cli.main import main
from warehouse_sim.dataset.validate import validate

pytestmark = pytest.mark.gl

RECIPE = """\
description: Two scenes of small images, to plant faults into.
extends: smoke
scenes: 2
scene: {targets: [pallet, carton]}
sensors:
  rig: dissertation
  lidar: vlp16
  clean: true
  camera: {width: 320, height: 240, focal_px: 240, cx: 157.3, cy: 121.6}
split: {train: 0.5, val: 0.0, test: 0.5}
"""


@pytest.fixture(scope="module")
def healthy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dataset of two scenes with four views, to read only."""
    folder = tmp_path_factory.mktemp("planted")
    (folder / "planted.yaml").write_text(RECIPE)
    recipe, out = str(folder / "planted.yaml"), str(folder / "data")
    assert main(["generate", recipe, "--seed", "17", "--out", out, "--workers", "1"]) == 0
    return folder / "data"


def test_a_healthy_dataset_passes(healthy: Path) -> None:
    assert [(check.name, check.detail) for check in validate(healthy) if not check.ok] == []


@pytest.mark.parametrize("fault", FAULTS, ids=[fault.name for fault in FAULTS])
def test_a_planted_fault_is_found(healthy: Path, tmp_path: Path, fault: Fault) -> None:
    copy = linked_copy(healthy, tmp_path / "copy")
    fault.plant(Folder(copy, np.random.default_rng(zlib.crc32(fault.name.encode()))))
    found = {check.name: check.detail for check in validate(copy) if not check.ok}
    assert fault.check in found, found
    assert fault.words in found[fault.check]


def test_there_are_forty_faults_and_more() -> None:
    assert len({fault.name for fault in FAULTS}) == len(FAULTS) >= 40
