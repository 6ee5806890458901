"""Every Python sample of README and docs runs, on small data."""

import io
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.dataset.toy import make_dataset
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.scene import sample_scene

ROOT = Path(__file__).resolve().parents[1]
RIG = "sensors=ws.Rig(camera=ws.Camera(width=306, height=92, focal_px=180))"
"""A quarter of the default camera's pixels each way, and its field of view."""
SMALL = {
    'load_recipe("demo")': 'load_recipe("smoke")',
    'ws.generate("demo", "out/dataset", scenes=2)': f'ws.generate(ws.recipe("smoke", {RIG}), "out/dataset", scenes=2)',
    '"smoke", light={"lux"': f'"smoke", {RIG}, light={{"lux"',
    'ws.Camera("d435"), views=2': "ws.Camera(width=212, height=120, focal_px=150), views=1",
    'ws.Camera("d435"), at': "ws.Camera(width=212, height=120, focal_px=150), at",
}
"""What stands in for what would take long."""


LONGEST = "python.md"
"""Its lines are those of tests/api/test_first_steps.py, nearly to the letter."""


def samples(page: Path) -> list[str]:
    """Return the Python samples of a page in order; a later one may use the names of an earlier one."""
    found = re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    for long, short in SMALL.items():
        found = [sample.replace(long, short) for sample in found]
    return found


PAGES = [page for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))) if samples(page)]


def given() -> dict[str, Any]:
    """Return what samples take for granted: a scene and its camera, and an image of a pallet as arrays."""
    recipe, mask = load_recipe("smoke"), np.zeros((240, 320), dtype=bool)
    mask[100:160, 120:220] = True
    return {
        "scene": sample_scene(recipe.scene, seed=0, scene_index=0),
        "camera": recipe.sensors.make_camera(),
        "depth": np.where(mask, 2.0, 4.0).astype(np.float32),
        "K": np.array([[300.0, 0.0, 159.5], [0.0, 300.0, 119.5], [0.0, 0.0, 1.0]]),
        "mask": mask,
        "rgb": np.full((240, 320, 3), 128, dtype=np.uint8),
    }


def test_the_pages_with_samples_are_known() -> None:
    assert {"README.md", "backends.md", "custom_objects.md", "dataset.md", "estimators.md"} <= {p.name for p in PAGES}


@pytest.fixture(scope="module")
def toy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_dataset(tmp_path_factory.mktemp("docs") / "data")


@pytest.mark.gl
@pytest.mark.pages
@pytest.mark.parametrize(
    "page", [pytest.param(page, id=page.name, marks=[pytest.mark.slow] * (page.name == LONGEST)) for page in PAGES]
)
def test_samples_run(page: Path, toy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(toy, tmp_path / "out" / "demo" / "data")
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.stdin", io.StringIO())  # of programs
    names = given()
    for number, sample in enumerate(samples(page)):
        exec(compile(sample, f"{page.name}, sample {number + 1}", "exec"), names)
