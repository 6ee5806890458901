"""What ``verify`` finds: files that were changed, and files that are not what the recipe makes."""

import json
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.dataset.toy import make_dataset, make_manifest
from tests.shared import Shared
from warehouse_sim.cli.main import main
from warehouse_sim.dataset.checks.findings import Check
from warehouse_sim.dataset.files.checksums import seal
from warehouse_sim.dataset.manifest import read_manifest, write_manifest
from warehouse_sim.errors import DatasetError
from warehouse_sim.generation.verify import (
    DEPTH_STEP,
    PIXEL_FRACTION,
    chosen_scenes,
    fraction_off,
    near_labels,
    near_numbers,
    verify,
)

SOFTPIPE = {
    "LIBGL_ALWAYS_SOFTWARE": "1",
    "GALLIUM_DRIVER": "softpipe",
    "MESA_GL_VERSION_OVERRIDE": "4.5",
    "MESA_GLSL_VERSION_OVERRIDE": "450",
}
"""Mesa's slow driver, a rasteriser of its own; it has all that is sampled with, but not all of OpenGL 4.5."""
COLOUR, LABELS = "bop/train/000000/rgb/000000.png", "bop/train/000000/scene_gt.json"


@pytest.fixture(scope="module")
def made(shared: Shared) -> Path:
    return shared.dataset(shared.small, scenes=1)


def sealed_again(root: Path) -> None:
    """Let the manifest name the files as they are, as one does who wants to hide a change."""
    manifest = read_manifest(root)
    write_manifest(root / "manifest.json", replace(manifest, checksums=seal(root)))


def by_name(checks: list[Check]) -> dict[str, Check]:
    return {check.name: check for check in checks}


@pytest.mark.gl
def test_what_was_made_here_is_made_again_to_the_byte(made: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["validate", str(made), "--regenerate", "1"]) == 0
    out = capsys.readouterr().out
    assert "FAIL" not in out
    assert "which drew it; bytes are compared" in out
    assert "1 observations of 1 scenes regenerated, the same bytes in" in out


@pytest.mark.gl
def test_a_hidden_change_is_found_by_making_it_again(made: Path, tmp_path: Path) -> None:
    root = shutil.copytree(made, tmp_path / "data")
    rows = json.loads((root / LABELS).read_text())
    rows["0"][0]["cam_t_m2c"][2] += 1.0
    (root / LABELS).write_text(json.dumps(rows))
    sealed_again(root)
    found = by_name(verify(root, 1))
    assert found["checksums"].ok
    assert found["regenerated"].detail == f"{root / LABELS}: is not what is made now"


@pytest.mark.gl
def test_another_driver_may_draw_a_little_otherwise_and_place_nothing_otherwise(made: Path, tmp_path: Path) -> None:
    root = shutil.copytree(made, tmp_path / "data")
    record = root / "scenes" / "000000.json"
    text = record.read_text()
    record.write_text(text.replace('"renderer": "raster on', '"renderer": "raster on another driver, not'))
    pixels = cv2.imread(str(root / COLOUR))
    cv2.imwrite(str(root / COLOUR), np.minimum(pixels, 250) + 5)
    sealed_again(root)
    found = by_name(verify(root, 1))
    assert all(check.ok for check in found.values()), found
    assert "geometry and labels exact" in found["driver"].detail
    assert {"geometry and labels", "pixels"} < found.keys()
    data = json.loads(record.read_text())
    data["objects"][-1]["T_world_object"][0][3] += 1e-6
    record.write_text(json.dumps(data))
    cv2.imwrite(str(root / COLOUR), np.roll(pixels, 5, axis=1))
    found = by_name(verify(root, 1))
    assert not found["checksums"].ok
    assert found["geometry and labels"].detail == f"{record}: is not what is made now"
    assert found["pixels"].detail == f"{root / COLOUR}: is not what is made now"


@pytest.mark.slow
@pytest.mark.gl
def test_a_second_driver_draws_what_the_first_drew(made: Path) -> None:
    command = [sys.executable, "-m", "warehouse_sim", "validate", str(made), "--regenerate", "1"]
    run = subprocess.run(command, env=os.environ | SOFTPIPE, capture_output=True, text=True, check=False)
    if "opens no OpenGL" in run.stderr:
        pytest.skip(f"no softpipe here: {run.stderr.strip()}")
    if "which drew it" in run.stdout:
        pytest.skip("softpipe is the driver of this machine")
    assert run.returncode == 0, run.stdout + run.stderr
    assert "pixels off: at most 0." in run.stdout
    assert "geometry and labels exact, images near" in run.stdout
    assert "FAIL" not in run.stdout


def test_checksums_are_those_of_coreutils_and_list_every_other_file(tmp_path: Path) -> None:
    data = make_dataset(tmp_path / "toy")
    subprocess.run(["sha256sum", "--check", "--strict", "--quiet", "SHA256SUMS"], cwd=data, check=True)
    listed = {line.split("  ")[1] for line in (data / "SHA256SUMS").read_text().splitlines()}
    there = {str(path.relative_to(data)) for path in data.rglob("*") if path.is_file()}
    assert listed == there - {"manifest.json", "README.md", "SHA256SUMS"}
    nominal = subprocess.run(["sha256sum", data / "SHA256SUMS"], capture_output=True, text=True, check=True).stdout
    assert json.loads((data / "manifest.json").read_text())["checksums"] == nominal.split()[0]


def test_a_dataset_that_no_recipe_made_cannot_be_made_again(tmp_path: Path) -> None:
    with pytest.raises(DatasetError, match="nothing can be regenerated"):
        verify(make_dataset(tmp_path / "toy", replace(make_manifest(), converted_from="theirs")), 1)


def test_samples_are_whole_scenes_spread_over_the_dataset() -> None:
    manifest = make_manifest()
    each = manifest.observations_per_scene
    assert len(chosen_scenes(manifest, 1)) == len(chosen_scenes(manifest, each)) == 1
    assert len(chosen_scenes(manifest, each + 1)) == 2
    assert chosen_scenes(manifest, 10**6) == list(range(manifest.scenes))


def near_depth(folder: Path, codes: int, more: int, step: float = DEPTH_STEP) -> bool:
    """Return whether all of an image of 16 bits and ``codes`` may be ``more`` codes more."""
    folder.mkdir(exist_ok=True)
    for name, value in (("one.png", codes), ("two.png", codes + more)):
        cv2.imwrite(str(folder / name), np.full((10, 10), value, np.uint16))
    return near_images(folder / "one.png", folder / "two.png", step)


def near_images(one: Path, two: Path, step: float = 0.0) -> bool:
    return fraction_off(one, two, step) <= PIXEL_FRACTION


def test_what_is_near(tmp_path: Path) -> None:
    one, two = tmp_path / "one.png", tmp_path / "two.png"
    depth = np.full((100, 100), 2000, np.uint16)
    cv2.imwrite(str(one), depth)
    for fraction, step, near in ((0.01, 500, True), (0.03, 500, False), (1.0, 10, True), (1.0, 11, False)):
        changed = depth.copy().ravel()
        changed[: int(fraction * depth.size)] += step
        cv2.imwrite(str(two), changed.reshape(depth.shape))
        assert near_images(one, two) is near, (fraction, step)
    assert not near_images(one, tmp_path / "missing.png")
    assert near_depth(tmp_path / "depth_2", 2 * 256, 2)
    assert not near_depth(tmp_path / "depth_2", 2 * 256, 3)
    # Two steps of disparity: z^2 / (f b) / 16.
    far = 10.0**2 / (447 * 0.095) / 16
    assert near_depth(tmp_path / "depth", 10_000, int(1000 * far))
    assert not near_depth(tmp_path / "depth", 10_000, int(1.1 * 1000 * far))
    # Ground truth, disparities and what a camera without errors reads round nowhere.
    assert not near_depth(tmp_path / "depth_clean", 10_000, 51)
    assert not near_depth(tmp_path / "disp_occ", 100 * 256, 129)
    assert not near_depth(tmp_path / "depth", 10_000, 51, step=0.0)
    row = "pallet 0.00 1 -0.52 598.0 170.0 719.0 227.0 0.14 0.80 1.20 -0.60 0.66 5.83 {turn}\n"
    one.write_text(row.format(turn=1.47))
    two.write_text(row.format(turn=1.47).replace("598.0", "600.0"))
    assert near_labels(one, two)
    two.write_text(row.format(turn=1.48))
    assert near_numbers(one, two)
    assert not near_labels(one, two)
    two.write_text(row.format(turn=1.47) * 2)
    assert not near_labels(one, two)
