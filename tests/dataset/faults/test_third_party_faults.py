"""The same faults in the BOP files alone, which then are a third-party folder: those that such a folder shows."""

import json
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.faults.folder import Folder, linked_copy
from tests.dataset.faults.table import THIRD_PARTY_FAULTS, Fault
from tests.dataset.formats.test_external_bop import write_folder
from tests.dataset.toy import failures, outcome
from warehouse_sim.cli.main import main
from warehouse_sim.dataset.validate import validate

HEALTHY = ["objects", "cameras", "labels", "images", "masks", "poses on images"]
HEALTHY += ["bop objects", "bop targets", "bop mask files"]


def strip(root: Path) -> Path:
    """Leave what BOP third-party folders hold."""
    for path in root.glob("*/*/scene_gt_info.json"):
        table = json.loads(path.read_text())
        for row in (row for rows in table.values() for row in rows):
            row.pop("instance_id", None)
        path.unlink()
        path.write_text(json.dumps(table))
    return root


@pytest.mark.gl
def test_a_healthy_folder_of_others_passes(healthy: Path, tmp_path: Path) -> None:
    checks = validate(strip(linked_copy(healthy, tmp_path / "copy") / "bop"))
    assert [(check.name, check.ok, check.checked) for check in checks] == [(name, True, True) for name in HEALTHY]


@pytest.mark.gl
@pytest.mark.parametrize("fault", THIRD_PARTY_FAULTS, ids=[fault.name for fault in THIRD_PARTY_FAULTS])
def test_a_fault_in_a_folder_of_others_is_found(healthy: Path, tmp_path: Path, fault: Fault) -> None:
    copy = linked_copy(healthy, tmp_path / "copy")
    fault.plant(Folder(copy, np.random.default_rng(zlib.crc32(fault.name.encode()))))
    found = outcome(strip(copy / "bop"), fault.check)
    assert not found.ok
    assert fault.words in found.detail


@pytest.mark.parametrize(("masks", "lacking"), [(True, 2), (False, 3)])
def test_what_a_folder_does_not_hold_is_not_checked(
    tmp_path: Path, masks: bool, lacking: int, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["validate", str(write_folder(tmp_path / "theirs", masks=masks))]) == 0
    out = capsys.readouterr().out
    assert out.count("--    ") == out.count("not checked: ") == lacking
    assert f"{9 - lacking} of {9 - lacking} checks hold" in out


def edit_table(root: Path, name: str, change: Callable[[dict], object]) -> None:
    path = root / "test" / "000003" / f"scene_{name}.json"
    data = json.loads(path.read_text())
    change(data)
    path.write_text(json.dumps(data))


def test_units_are_told_without_masks(tmp_path: Path) -> None:
    root = write_folder(tmp_path / "theirs", masks=False)
    edit_table(root, "gt", lambda data: data["1"][0].update(cam_t_m2c=[0.02, 0.0, 1.5]))
    found = failures(root)
    assert "millimetres are meant" in found["labels"]


def test_an_unknown_object_is_named(tmp_path: Path) -> None:
    root = write_folder(tmp_path / "theirs")
    edit_table(root, "gt", lambda data: data["2"][0].update(obj_id=9))
    found = failures(root)
    assert "obj_id 9 is no known object" in found["bop objects"]
