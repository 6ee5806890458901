"""A stranger's package brings one plug-in of each kind, and every command takes them as its own.

The package under ``package/`` is installed by pip into an environment of its own; nothing of ours is patched.
"""

import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.shared import Shared, hashes
from tests.third_party.environment import Environment, Session
from warehouse_sim.cli.main import main

pytestmark = pytest.mark.gl
PACKAGE = Path(__file__).parent / "package"
NAMES = ("kettle_drum", "ultrasonic_ring", "flat_rays", "flat_files", "rectangle", "low_things")
RECIPE = """
extends: smoke
description: A kettle drum in the aisle, and a ring of rangers on the truck.
scene:
  targets: [pallet, kettle_drum]
  traffic: {objects: [kettle_drum], own: {min: 1, max: 1}}
sensors:
  camera: {width: 480, height: 200, focal_px: 300}
  more:
    ring: {sensor: ultrasonic_ring, mount: {carrier: vehicle, up: 0.4}, rangers: 12, sigma: 0.005}
"""


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Session]:
    folder = tmp_path_factory.mktemp("stranger")
    with installed(folder).session() as started:
        yield started


def installed(folder: Path) -> Environment:
    """Return an environment in which the package is installed."""
    shutil.copytree(PACKAGE, folder / "package", ignore=shutil.ignore_patterns("__pycache__"))
    environment = Environment.create(folder / "environment")
    environment.install(folder / "package")
    return environment


@pytest.fixture(scope="module")
def made(session: Session, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder that holds the recipe, and as ``data`` the dataset that is made with all of them."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "kettle.yaml").write_text(RECIPE, encoding="utf-8")
    session.command(
        "generate", "kettle.yaml", "--out", "data", "--scenes", 2, "--workers", 2, "--formats", "flat_files",
        "--backend", "flat_rays", "--backend-options", "shade=0.9", folder=folder,
    )  # fmt: skip
    return folder


@pytest.mark.slow
def test_it_is_listed_while_it_is_installed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list"]) == 0
    before = capsys.readouterr().out  # as where nothing is installed
    assert not set(NAMES) & set(re.split(r"[,\s]+", before))
    environment = installed(tmp_path)
    listed = environment.run_command("list")
    assert [name for name in NAMES if name not in listed] == []
    environment.pip("uninstall", "--quiet", "--yes", "stranger-warehouse")
    assert environment.run_command("list") == before


def test_our_recipes_do_not_change(session: Session, shared: Shared, tmp_path: Path) -> None:
    generate = ("generate", shared.bare, "--scenes", 3, "--formats", "bop", "--workers", 1, "--out", "with")
    session.command(*generate, folder=tmp_path)
    assert hashes(tmp_path / "with") == hashes(shared.dataset(shared.bare, scenes=3, formats=("bop",)))


def test_a_preview_shows_object_and_sensor(session: Session, made: Path) -> None:
    preview, sheets = ("preview", "kettle.yaml", "--backend", "flat_rays", "--backend-options"), []
    for shade in (0.0, 0.9):
        session.command(*preview, f"shade={shade}", "--out", f"{shade}.png", folder=made)
        sheets.append(cv2.imread(str(made / f"{shade}.png")))
        assert sheets[-1] is not None
    assert not np.array_equal(*sheets)


@pytest.mark.parametrize("option", ["shadow=1", "shade=2", "shade=dark"])
def test_an_option_that_the_backend_lacks_is_rejected_by_name(session: Session, made: Path, option: str) -> None:
    preview = ("preview", "kettle.yaml", "--backend", "flat_rays", "--out", "x.png")
    session.command(*preview, "--backend-options", option, folder=made, code=2)


def test_the_dataset_holds_what_the_sensors_read(made: Path) -> None:
    data = made / "data"
    manifest = json.loads((data / "manifest.json").read_text())
    assert manifest["formats"] == ["flat_files"]
    assert "flat_rays 1.2.3" in manifest["renderers"][0]
    assert "stranger-warehouse" in json.dumps(manifest)
    readings = sorted((data / "readings" / "ring").iterdir())
    assert len(readings) == manifest["scenes"] * manifest["observations_per_scene"]
    distances = [np.load(path, allow_pickle=False)["distance"] for path in readings]
    assert all(distance.shape == (12,) and distance.dtype == np.float32 for distance in distances)
    # The rangers are 0.4 m above a floor that the lowest rays of their cones meet at 1.55 m or a little beyond.
    assert all(((distance > 0.05) & (distance < 1.8)).all() for distance in distances)
    models = {info["name"] for info in json.loads((data / "objects.json").read_text()).values()}
    assert "kettle_drum" in models


def test_its_checks_are_run_and_find_what_is_broken(session: Session, made: Path, tmp_path: Path) -> None:
    assert "flat files" in session.command("validate", "data", folder=made)
    broken = shutil.copytree(made / "data", tmp_path / "broken")
    path = next((broken / "flat_files").rglob("scene.json"))
    path.write_text(json.dumps({"objects": {}}))
    assert "is not in scene.json" in session.command("validate", broken, folder=made, code=1)
    other = shutil.copytree(made / "data", tmp_path / "other")
    ring = next((other / "readings/ring").iterdir())
    ring.unlink()
    assert ring.name in session.command("validate", other, folder=made, code=1)


def test_the_reader_gives_the_reading_back(session: Session, made: Path) -> None:
    program = """
from pathlib import Path
from warehouse_sim.dataset.reader import DatasetReader
reader = DatasetReader(Path("data"))
image = reader.images("test")[0]
ring = reader.readings(image)["ring"]
print(image.scene_id, image.image_id, *ring.reading.channels["distance"])
"""
    scene, image, *distance = session.program(program, made).split()
    stored = np.load(made / f"data/readings/ring/{int(scene):06d}_{int(image):06d}.npz", allow_pickle=False)
    assert np.array_equal(np.array(distance, np.float32), stored["distance"])


def test_its_estimator_and_detector_are_scored_and_reported(session: Session, made: Path) -> None:
    for detections in ("gt", "low_things"):
        csv = f"rectangle-{detections.replace('_', '-')}.csv"
        predict = ("predict", "rectangle", "--data", "data", "--out", csv, "--detections", detections)
        session.command(*predict, folder=made)
        session.command("evaluate", csv, "--data", "data", "--out", detections, folder=made)
    session.command("report", "data", "gt", "low_things", "--out", "report.html", folder=made)
    scores = {name: json.loads((made / name / "scores.json").read_text()) for name in ("gt", "low_things")}
    page = (made / "report.html").read_text(encoding="utf-8")
    assert [word for word in ("ultrasonic_ring", "distance", "rectangle") if word not in page] == []
    assert scores["gt"]["method"] == "rectangle"
    assert scores["gt"]["counts"]["found"] > scores["low_things"]["counts"]["found"] > 0
    assert scores["gt"]["overall"]["metrics"]["add_10pct"] > 0.5


def test_its_backend_passes_the_conformance_suite(session: Session, tmp_path: Path) -> None:
    program = """
from warehouse_sim.render import open_renderer
from warehouse_sim.render.conformance import CHECKS, check_backend
with open_renderer("flat_rays") as renderer:
    check_backend("flat_rays", renderer)
print(len(CHECKS), "checks hold")
"""
    assert "checks hold" in session.program(program, tmp_path)


def test_a_setting_of_its_sensor_is_held_to_its_range(session: Session, made: Path) -> None:
    (made / "wide.yaml").write_text(RECIPE.replace("rangers: 12", "rangers: 65"), encoding="utf-8")
    session.command("preview", "wide.yaml", "--out", "wide.png", folder=made, code=2)
