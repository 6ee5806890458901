"""Faults planted at random places of a rendered dataset: each is found, by the check and in the words of the table."""

import zlib
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.faults.folder import Folder, linked_copy
from tests.dataset.faults.table import FAULTS, Fault
from tests.dataset.toy import outcome
from warehouse_sim.dataset.validate import validate

pytestmark = pytest.mark.gl


def test_a_healthy_dataset_passes(healthy: Path) -> None:
    assert [(check.name, check.detail) for check in validate(healthy) if not check.ok] == []


@pytest.mark.parametrize("fault", FAULTS, ids=[fault.name for fault in FAULTS])
def test_a_planted_fault_is_found(healthy: Path, tmp_path: Path, fault: Fault) -> None:
    copy = linked_copy(healthy, tmp_path / "copy")
    fault.plant(Folder(copy, np.random.default_rng(zlib.crc32(fault.name.encode()))))
    found = outcome(copy, fault.check)
    assert not found.ok
    assert fault.words in found.detail


def test_there_are_forty_faults_and_more() -> None:
    assert len({fault.name for fault in FAULTS}) == len(FAULTS) >= 40
