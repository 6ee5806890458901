"""The same faults in the BOP files alone, which then are a third-party folder: those that such a folder shows."""

import json
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.faults import geometry, lists, pixels
from tests.dataset.faults.folder import Folder, linked_copy
from tests.dataset.faults.table import FAULTS, Fault
from tests.dataset.formats.test_external_bop import write_folder
from tests.dataset.toy import failures
from warehouse_sim.cli.main import main
from warehouse_sim.dataset.validate import validate

HEALTHY = ["objects", "cameras", "labels", "images", "masks", "poses on images"]
HEALTHY += ["bop objects", "bop targets", "bop mask files"]
THIRD_PARTY_FAULTS = (
    Fault("models in metres", geometry.models_in_metres, "labels", "may be in metres where millimetres are meant"),
    Fault("a translation in metres", geometry.translation_in_metres, "labels", "may be in metres where millimetres"),
    Fault("depth scale of 0.1 mm", geometry.wrong_depth_scale, "poses on images", "depth_scale or its unit is wrong"),
    Fault("depth as range", pixels.depth_as_range, "poses on images", "hold the distance to the camera"),
    Fault("cx and cy exchanged", geometry.principal_point_exchanged, "poses on images", "pose, model, K or mask"),
    Fault("left-handed rotation", geometry.pose_left_handed, "labels", "is not a rotation"),
    Fault(
        "object axes exchanged", geometry.pose_turned_everywhere, "poses on images", "pose, model, K or mask is wrong"
    ),
    Fault("object moved", geometry.pose_aside_everywhere, "poses on images", "pose, model, K or mask is wrong"),
    Fault("poses in OpenGL's axes", geometry.poses_of_opengl, "labels", "is behind the camera"),
    Fault("axes of a mesh exchanged", geometry.mesh_axes_exchanged, "objects", "m, the mesh has"),
    Fault("mesh mirrored", geometry.mesh_inside_out, "objects", "inside out"),
    Fault("false symmetry", geometry.symmetry_not_the_objects, "objects", "moves the surface elsewhere"),
    Fault("visible boxes one pixel larger", pixels.visible_box_one_more, "masks", "without COCO's one more"),
    Fault("visible fraction wrong", pixels.fraction_of_the_image, "labels", "visib_fract is"),
    Fault("mask of another image", pixels.mask_of_another_image, "masks", "mask of target"),
    Fault("mask inverted", pixels.mask_inverted, "masks", "pixels, its label says"),
    Fault("colour of another scene", pixels.colour_and_gt_of_another_scene, "images", "shows no edges where"),
    Fault(
        "truncated PNG", lambda folder: pixels.cut_image(folder, ("rgb", "depth")), "images", "is a damaged PNG image"
    ),
    Fault("NaN in a table", lists.no_number, "labels", "NaN is no JSON number"),
    Fault("target counted wrong", lists.target_counted_wrong, "bop targets", "lists"),
)


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
    found = [check for check in validate(strip(copy / "bop")) if not check.ok]
    assert fault.check in {check.name for check in found}, found
    assert fault.words in next(check.detail for check in found if check.name == fault.check)


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


@pytest.mark.parametrize("fault", [*FAULTS, *THIRD_PARTY_FAULTS], ids=lambda fault: fault.name)
def test_the_docs_list_each_fault(fault: Fault) -> None:
    rows = (Path(__file__).parents[3] / "docs" / "validate.md").read_text(encoding="utf-8").splitlines()
    assert f"| {fault.name} | {fault.check} | ... {fault.words} ... |" in rows
