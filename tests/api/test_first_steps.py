"""The lines that a newcomer writes, as they stand: those of the front door's design, and ten guesses without a manual.

Only what takes long is made smaller, see ``SMALL``.
"""

from pathlib import Path
from typing import Any

import pytest

import warehouse_sim as ws
from tests.api.crates import write_crate

pytestmark = pytest.mark.gl
SMALL = {
    'generate("demo"': 'generate("smoke"',
    'ws.Scene(recipe, seed=seed); scene.replace("carton_600x400x300"': (
        'ws.Scene("smoke", seed=seed); scene.replace("carton_600x400x400"'
    ),
    "range(10)": "range(3)",
    "views=8": "views=1",
}
"""What stands in for what would take long."""
DATASET = """
import warehouse_sim as ws
data = ws.generate("demo", "out", scenes=2)          # name, path or Recipe; str or Path everywhere
obs = data[3]; len(data); data.split("train")        # ws.Dataset("out") opens any readable folder
obs.rgb, obs.depth, obs.points, obs.camera           # numpy, SI, read on demand
for o in obs.objects: o.name, o.T_camera_object, o.mask, o.visible_fraction, o.box_3d
obs.draw("look.png")                                 # shows itself in a notebook
loader = torch.utils.data.DataLoader(data.torch("rgb", "depth", "poses"), 2)
"""
RECIPE = """
recipe = ws.recipe("selective_rack", sensors=ws.Rig(camera="d435_720p", lidar="os1_64", on="forklift", height=1.2), light="night", visible=(0.4, 0.6))
recipe.add("crate.glb", name="crate", places=["shelf", "floor"])
"""  # noqa: E501  as it stands
SCENE = """
scene = ws.Scene(); scene.add("shelf_bay", x=2.0); scene.add("epal1", x=1.0, yaw_deg=10); scene.light("nominal", lux=300)
shot = scene.settle().render(ws.Camera("d435"), at=(-2, 0, 1.2), look_at=(1, 0, 0.1))   # shot.rgb, .depth, .instance_mask
"""  # noqa: E501  as it stands
SCORES = """
scores = data.evaluate(my_estimator)                 # any callable or object; ws.predict(...), ws.evaluate(...), ws.report(...)
"""  # noqa: E501  as it stands
WRITER = """
with ws.Writer("out", formats=["bop", "coco"]) as out:     # a hand-made or changed scene, stored with labels, manifest and splits
    for seed in range(10):
        scene = ws.Scene(recipe, seed=seed); scene.replace("carton_600x400x300", "crate.glb"); scene.light("nominal", lux=50 + 20 * seed)
        out.write(scene.settle().render(ws.Camera.from_file("camera_info.yaml"), views=8))
"""  # noqa: E501  as it stands
CAMERA_INFO = """
image_width: 320
image_height: 240
camera_matrix: {rows: 3, cols: 3, data: [262.5, 0, 159.5, 0, 263, 119.5, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [-0.1, 0.02, 0.001, -0.0005, 0]}
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return an empty folder to work in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(lines: str, **given: Any) -> dict[str, Any]:
    """Run lines and return what they name."""
    for long, short in SMALL.items():
        lines = lines.replace(long, short)
    names = {"ws": ws, **given}
    exec(lines, names)
    return names


def test_a_dataset_is_made_read_drawn_and_loaded(here: Path) -> None:
    import torch

    names = run(DATASET, torch=torch)
    assert (len(names["data"]), names["obs"].scene_id, names["obs"].image_id) == (4, 1, 1)
    assert (here / "look.png").stat().st_size > 10_000
    shapes = {name: tuple(value.shape) for name, value in next(iter(names["loader"])).items()}
    assert shapes["rgb"] == (2, 3, 370, 1224)
    assert shapes["depth"] == (2, 1, 370, 1224)
    assert shapes["poses"][2:] == (4, 4)


def test_a_recipe_is_changed(here: Path) -> None:
    write_crate(here)
    recipe = run(RECIPE)["recipe"]
    assert repr(recipe) == "<Recipe selective_rack: 12 observations a scene, 1280 x 720 px, labels of pallet, crate>"
    assert recipe.settings["scene"]["lights"]["lux"] is None  # the preset's, not that of the recipe before


def test_a_scene_is_put_together_and_looked_at(here: Path) -> None:
    shot = run(SCENE)["shot"]
    assert {o.name for o in shot.objects} == {"shelf_bay", "epal1"}
    assert shot.rgb.shape == (480, 848, 3)
    assert shot.depth.shape == shot.instance_mask.shape == (480, 848)


def test_an_estimator_is_scored(here: Path, smoke: Path, oracle: Any) -> None:
    names = run(SCORES, data=ws.Dataset(smoke), my_estimator=oracle)
    assert names["scores"]["overall"]["metrics"]["add_10pct"] == 1.0


def test_scenes_are_stored_as_a_dataset(here: Path) -> None:
    write_crate(here, size=(0.5, 0.3, 0.35))
    (here / "camera_info.yaml").write_text(CAMERA_INFO)
    run(WRITER)
    data = ws.Dataset("out")
    assert len(data) == 3
    assert {o.name for obs in data for o in obs.objects} >= {"epal1", "crate"}
    assert data[0].camera.distortion.k1 == -0.1
    assert [name for name in data.splits if len(data.split(name))] == ["train", "val", "test"]
    checks = ws.validate("out")
    assert checks.ok, str(checks)


GUESSES = {
    "open": 'data = ws.Dataset("out")',
    "len": 'len(ws.Dataset("out"))',
    "index": 'ws.Dataset("out")[0]',
    "rgb": 'ws.Dataset("out")[0].rgb.shape',
    "points": 'ws.Dataset("out")[0].points.shape',
    "draw": 'ws.Dataset("out")[0].draw()',
    "scene by hand": 's = ws.Scene(); s.add("epal1"); s.settle().render(at=(-2, 0, 1.5), look_at=(0, 0, 0)).rgb',
    "own class": "class Mine:\n    def estimate(self, image): return []\nws.Dataset('out').evaluate(Mine())",
    "night": 'ws.recipe("demo", light="night")',
    "d435": 'ws.Camera("d435").K',
}


@pytest.mark.parametrize("guess", GUESSES)
def test_what_a_newcomer_guesses_works(guess: str, here: Path, smoke: Path) -> None:
    (here / "out").symlink_to(smoke)
    run(GUESSES[guess])
