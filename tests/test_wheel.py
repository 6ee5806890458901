"""The wheel carries its data and works away from the checkout."""

import hashlib
import subprocess
import sys
import zipfile
from pathlib import Path

import cv2
import pytest

from locks.contents import bill
from locks.licences import is_copyleft

ROOT = Path(__file__).resolve().parents[1]
RUN = """
import sys, warehouse_sim
from warehouse_sim.cli.main import main
print(warehouse_sim.__file__)
sys.exit(main(["list"]) or main(["preview", sys.argv[1], "--out", sys.argv[2]]))
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """Return the wheel of this checkout."""
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", str(folder)]
    subprocess.run(build, check=True, cwd=ROOT, capture_output=True)
    (made,) = folder.glob("*-py3-none-any.whl")
    return made


@pytest.fixture(scope="module")
def installed(wheel) -> Path:
    """Return a folder that holds the package as a user's installation would: what a wheel of pure Python unpacks to."""
    zipfile.ZipFile(wheel).extractall(wheel.parent / "site")
    return wheel.parent / "site"


def run_from_root(installed: Path, *arguments: str) -> str:
    """Run Python in / with the installed package first on the path."""
    command = [sys.executable, *arguments]
    environment = {"PYTHONPATH": str(installed), "PATH": "/usr/bin:/bin", "HOME": "/tmp"}
    return subprocess.run(command, check=True, cwd="/", env=environment, capture_output=True, text=True).stdout


@pytest.mark.gl
def test_it_is_the_wheel_that_runs_and_finds_recipes_textures_and_shaders(installed, shared, tmp_path) -> None:
    out = run_from_root(installed, "-c", RUN, str(shared.small), str(tmp_path / "preview.png"))
    assert str(installed) in out
    assert "demo" in out
    assert "smoke" in out
    assert cv2.imread(str(tmp_path / "preview.png")).std() > 20.0


def test_of_the_benchmarks_it_carries_results_and_suites_and_no_code(installed) -> None:
    carried = {
        path.name for path in (installed / "warehouse_sim" / "_data" / "benchmarks").rglob("*") if path.is_file()
    }
    here = (path for kind in ("results", "suites") for path in (ROOT / "benchmarks" / kind).rglob("*"))
    assert carried == {path.name for path in here if path.is_file()}


def test_the_bill_of_materials_lists_weights_and_packages_with_licences(wheel) -> None:
    listed = {item["name"]: item for item in bill(wheel)["components"]}
    for path in (ROOT / "models").rglob("*.safetensors"):
        item = listed[f"warehouse_sim/_data/{path.relative_to(ROOT)}"]
        assert item["hashes"][0]["content"] == hashlib.sha256(path.read_bytes()).hexdigest()
        assert item["licenses"] == [{"license": {"id": "Apache-2.0"}}]
    assert {"numpy", "torch", "mujoco", "plotly"} <= listed.keys()
    for item in listed.values():
        licence = item["licenses"][0]["license"]
        assert not is_copyleft(licence.get("id") or licence["name"]), item["name"]


@pytest.mark.slow
def test_the_sdist_gives_the_same_wheel(tmp_path) -> None:
    build = [sys.executable, "-m", "hatchling", "build", "--directory", str(tmp_path)]
    subprocess.run([*build, "--target", "sdist", "--target", "wheel"], check=True, cwd=ROOT)
    (sdist,), (wheel,) = tmp_path.glob("*.tar.gz"), tmp_path.glob("*.whl")
    again = tmp_path / "again"
    pip = [sys.executable, "-m", "pip", "--quiet", "wheel", "--no-deps", "--no-build-isolation"]
    subprocess.run([*pip, "--wheel-dir", str(again), str(sdist)], check=True)
    (from_sdist,) = again.glob("*.whl")
    names = [set(zipfile.ZipFile(path).namelist()) for path in (wheel, from_sdist)]
    assert names[0] == names[1]
