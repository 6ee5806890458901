"""A frozen set gives strangers no ground truth, checks its seal, and scores as the open dataset does."""

import csv
import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.shared import Shared
from warehouse_sim.benchmark.entrants.entrant import Oracle, Request
from warehouse_sim.benchmark.result import SuiteResult, read_result
from warehouse_sim.benchmark.run import RunConfig, run_suite
from warehouse_sim.benchmark.sealed.make import make_set, seeds_of
from warehouse_sim.benchmark.sealed.public import levelled
from warehouse_sim.benchmark.sealed.score import evaluate_sealed, log_evaluations
from warehouse_sim.benchmark.sealed.seal import read_facts, require_sealed, unsealed
from warehouse_sim.benchmark.suite import ConditionConfig, DataConfig, LeastConfig, Suite, load_suite
from warehouse_sim.cli.main import main
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results import predictions
from warehouse_sim.errors import InputError, OutputError
from warehouse_sim.estimators.gravity import down_of_camera
from warehouse_sim.estimators.predict import predict
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.geometry.pose import invert

pytestmark = pytest.mark.gl
_LAYOUTS = ("selective_rack", "industrial")
_SEEDS = {"selective_rack": 7_310_274_519_113_001, "industrial": 7_310_274_519_113_002}


def tiny() -> Suite:
    """Return the suite of warehouses on two small datasets, with ground-truth masks."""
    data = DataConfig("smoke", 71, 1, 2)
    return replace(
        load_suite("warehouses"),
        data={name: replace(data, seed=71 + number) for number, name in enumerate(_LAYOUTS)},
        conditions={name: ConditionConfig(name) for name in _LAYOUTS},
        compare=(),
        detectors=(),
        least=LeastConfig(dockable=1, ground_truths=2),
    )


def make_tiny(folder: Path) -> None:
    """Make a small set of scenes that are known to have pallets that a truck can take.

    It goes on with three runs: one that was killed in the second layout, one that found too few pallets, and one that
    had sealed before the public half was out. None of them makes the first layout again.
    """
    work = folder / "tiny-v1.unsealed"
    begun(work, _SEEDS)

    def killed(name: str, done: int, total: int) -> None:
        if name == _LAYOUTS[1]:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make_set(tiny(), folder / "tiny-v1", 1, killed)
    (first,) = work.glob(f"data/{_LAYOUTS[0]}-*/manifest.json")
    made_at = first.stat().st_mtime_ns
    many = replace(tiny(), least=LeastConfig(dockable=1000))
    with pytest.raises(InputError, match=rf"and 1000 that a truck can take: {_LAYOUTS[0]} has \d+ of \d+; .*raise"):
        make_set(many, folder / "tiny-v1", 1)
    (folder / "tiny-v1.sealed").write_bytes(b"of the run before")

    def made_once(name: str, done: int, total: int) -> None:
        pytest.fail(f"{name} is regenerated")

    assert first.stat().st_mtime_ns == made_at
    make_set(tiny(), folder / "tiny-v1", 1, made_once)


def begun(work: Path, seeds: dict[str, int]) -> None:
    work.mkdir(parents=True)
    (work / "seeds.json").write_text(json.dumps(seeds))


@pytest.fixture(scope="module")
def frozen(shared: Shared) -> Path:
    """Return the public folder of a small set; the sealed file lies beside it."""
    return shared.made("frozen", make_tiny) / "tiny-v1"


@pytest.fixture(scope="module")
def whole(frozen: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return the datasets of both halves put together."""
    return unsealed(frozen.with_name("tiny-v1.sealed"), frozen, tmp_path_factory.mktemp("whole"))


@pytest.mark.parametrize(
    "word", ["seed", "instance", "cam_R_m2c", "cam_t_m2c", "visib", "bbox", "access", "free", "pose"]
)
def test_no_public_table_says_anything_of_the_truth(frozen: Path, word: str) -> None:
    tables = [path for path in frozen.rglob("*") if path.suffix in (".json", ".txt", ".csv", ".yaml", ".md", ".sha256")]
    assert len(tables) >= 8
    for path in tables:
        assert word not in path.read_text().lower(), path


def test_public_files_are_images_calibration_cad_and_lists_of_targets(frozen: Path) -> None:
    kinds = {
        path.relative_to(frozen).parts[1] for path in frozen.rglob("*") if path.is_file() and path.parent != frozen
    }
    assert kinds == {
        "camera.json",
        "classes.json",
        "names.json",
        "models",
        "models_eval",
        "test",
        "test_targets_bop19.json",
    }
    scenes = {path.name for path in frozen.glob("*/test/*/*")}
    assert scenes == {"rgb", "depth", "scene_camera.json"}
    assert not list(frozen.parent.glob("*.unsealed")), "what it was made in is gone"


def test_no_public_file_holds_a_seed(frozen: Path) -> None:
    seeds = read_facts(frozen.with_name("tiny-v1.sealed")).seeds
    assert len({*seeds.values()}) == len(_LAYOUTS)
    for path in (path for path in frozen.rglob("*") if path.is_file()):
        data = path.read_bytes()
        assert not any(str(seed).encode() in data or seed.to_bytes(8, "little") in data for seed in seeds.values()), (
            path
        )
        if path.suffix == ".png":
            assert not any(kind in data for kind in (b"tEXt", b"iTXt", b"zTXt", b"eXIf", b"tIME")), path


def test_no_public_camera_says_where_it_stands(frozen: Path, whole: dict[str, Path]) -> None:
    for name, root in whole.items():
        private, public = DatasetReader(root).images("test"), DatasetReader(frozen / name).images("test")
        assert len(private) == len(public) > 0
        known = DatasetReader(root).objects
        told = DatasetReader(frozen / name).objects
        assert [(n, it.name, it.class_name) for n, it in told.items()] == [
            (n, it.name, it.class_name) for n, it in known.items()
        ]
        for mine, theirs in zip(private, public, strict=True):
            assert not theirs.targets
            np.testing.assert_allclose(theirs.T_world_camera[:2, 3], 0.0, atol=1e-9)
            down = down_of_camera(mine.T_world_camera)
            np.testing.assert_allclose(down_of_camera(theirs.T_world_camera), down, atol=1e-6)
            assert abs(theirs.T_world_camera[2, 3] - mine.T_world_camera[2, 3]) < 1e-6


def test_a_levelled_camera_is_rigid_and_looks_along_x() -> None:
    T_world_camera = np.eye(4)
    T_world_camera[:3, :3] = np.array([[0.6, 0.0, 0.8], [0.8, 0.0, -0.6], [0.0, 1.0, 0.0]])
    T_world_camera[:3, 3] = 3.0, -2.0, 1.5
    T = levelled(T_world_camera)
    np.testing.assert_allclose(T @ invert(T), np.eye(4), atol=1e-12)
    assert abs(T[1, 2]) < 1e-12 < T[0, 2]
    assert T[:3, 3].tolist() == [0.0, 0.0, 1.5]


def answered(whole: dict[str, Path], folder: Path) -> Path:
    """Write the labels as predictions on a set, and return their folder."""
    folder.mkdir()
    for name, root in whole.items():
        found = Oracle().estimates(
            Request(DatasetReader(root), "test", ConditionConfig(name), lambda fraction, note: None)
        )
        predictions.write(folder / f"{name}.csv", found)
    return folder


def test_truth_is_right_in_every_number_and_a_result_has_no_image(
    frozen: Path, whole: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sealed, sums = str(frozen.with_name("tiny-v1.sealed")), str(frozen / "sealed.sha256")
    mine = answered(whole, tmp_path / "mine")
    assert main(["evaluate", str(mine), "--sealed", sealed, "--sums", sums, "--out", str(tmp_path / "s")]) == 0
    assert "frozen set tiny-v1" in capsys.readouterr().out
    result = read_result(tmp_path / "s" / "warehouses-v1.json")
    assert result.rows
    assert all(row.value == 1.0 for row in result.rows)
    assert {row.condition for row in result.rows} == {"worst layout", *_LAYOUTS}
    assert all(item.seed is None for item in result.data)
    assert [path.name for path in (tmp_path / "s").iterdir()] == ["warehouses-v1.json"]
    (line,) = [line for line in logged(frozen) if line["estimator"] == "mine"]
    assert (line["value"], line["suite"], line["weights"]) == ("1.0000", "warehouses-v1", "")
    assert line["layout"] in _LAYOUTS
    open_one = run_on(frozen, tmp_path / "bench", "oracle")
    assert [row.value for row in open_one.rows] == [row.value for row in result.rows]


def logged(frozen: Path) -> list[dict[str, str]]:
    with frozen.with_name("tiny-v1.sealed.evaluations.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_an_evaluation_is_added_to_the_log_and_one_without_a_headline_too(frozen: Path, tmp_path: Path) -> None:
    sealed = tmp_path / "tiny-v1.sealed"
    whole_run = run_on(frozen, tmp_path / "bench", "shuffled", "oracle")
    log_evaluations(sealed, whole_run)
    log = log_evaluations(sealed, replace(whole_run, rows=(), quick=True))
    with log.open(newline="") as file:
        lines = list(csv.DictReader(file))
    assert [line["estimator"] for line in lines] == ["shuffled", "oracle"] * 2
    assert [line["value"] for line in lines[1:]] == ["1.0000", "", ""]
    assert [line["suite"] for line in lines[1:3]] == ["warehouses-v1", "warehouses-v1, quick"]
    assert float(lines[0]["low"]) <= float(lines[0]["value"]) <= float(lines[0]["high"])


def test_the_datasheet_counts_and_croissant_names_each_image_once(frozen: Path) -> None:
    text, data = (frozen / "README.md").read_text(), json.loads((frozen / "croissant.json").read_text())
    for name in _LAYOUTS:
        targets = json.loads((frozen / name / "test_targets_bop19.json").read_text())
        images = list((frozen / name).glob("test/*/depth/*.png"))
        assert f"| `{name}` | 1 | {len(images)} | {sum(item['inst_count'] for item in targets)} |" in text
    found = [path for item in data["distribution"] if "includes" in item for path in frozen.glob(item["includes"])]
    assert len(found) == len(set(found))
    assert set(frozen.rglob("*.png")) <= set(found)
    assert data["license"] == "Apache-2.0"


def run_on(frozen: Path, out: Path, *who: str) -> SuiteResult:
    """Run the suite as the maker of the set does."""
    sealed = frozen.with_name("tiny-v1.sealed")
    return run_suite(tiny(), who, config=RunConfig(out, workers=1), data=frozen, sealed=sealed)


def test_a_stranger_scores_what_the_maker_scores(frozen: Path, tmp_path: Path) -> None:
    stranger = tmp_path / "rectangle-fit"
    stranger.mkdir()
    for name in _LAYOUTS:  # what a stranger has no masks for is found by a front end
        found = predict("rectangle-fit", frozen / name, "test", PredictConfig(detections="detector-depth+cluster"))
        predictions.write(stranger / f"{name}.csv", found)
    theirs = evaluate_sealed(stranger, frozen.with_name("tiny-v1.sealed"), frozen / "sealed.sha256")
    mine = run_on(frozen, tmp_path / "bench", str(stranger))
    numbers = [{(row.condition, row.group, row.metric): row.value for row in it.rows} for it in (theirs, mine)]
    assert numbers[0] == numbers[1] != {}


def test_the_ladder_ends_at_the_truth_and_has_the_ceiling_below_it(frozen: Path, tmp_path: Path) -> None:
    result = run_on(frozen, tmp_path, "shuffled", "oracle-icp", "oracle")
    assert not result.left_out
    worst = {
        row.estimator: row.value for row in result.rows if row.condition == "worst layout" and row.metric == "add_10pct"
    }
    page = (tmp_path / "results" / "warehouses-tiny-v1.md").read_text()
    assert "| layout | n | shuffled | oracle-icp | oracle |" in page
    assert worst["shuffled"] < worst["oracle-icp"] <= worst["oracle"] == 1.0


def test_a_changed_a_strange_and_a_missing_file_are_told_apart(frozen: Path, tmp_path: Path) -> None:
    sealed, sums = frozen.with_name("tiny-v1.sealed"), frozen / "sealed.sha256"
    require_sealed(sealed, sums)
    with pytest.raises(InputError, match="no such sealed file"):
        require_sealed(tmp_path / "x.sealed", sums)
    with pytest.raises(InputError, match=r"lists no tiny-v1\.sealed"):
        require_sealed(sealed)
    changed = tmp_path / sealed.name
    shutil.copyfile(sealed, changed)
    with changed.open("ab") as file:
        file.write(b"\0")
    with pytest.raises(InputError, match="another set or was changed"):
        require_sealed(changed, sums)
    empty = tmp_path / "empty"
    empty.mkdir()
    with pytest.raises(InputError, match=r"lacks selective_rack\.csv, industrial\.csv"):
        evaluate_sealed(empty, sealed, sums)


def test_images_of_another_set_are_rejected(frozen: Path, tmp_path: Path) -> None:
    changed = tmp_path / "tiny-v1"
    shutil.copytree(frozen, changed)
    image = next(changed.glob("industrial/test/*/depth/*.png"))
    image.write_bytes(image.read_bytes() + b"\0")
    with pytest.raises(InputError, match="industrial: is not what tiny-v1 was sealed with"):
        unsealed(frozen.with_name("tiny-v1.sealed"), changed, tmp_path / "out")


def test_a_set_is_never_made_twice_and_goes_on_with_its_seeds(frozen: Path, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="is there already"):
        make_set(tiny(), frozen, 1)
    assert read_facts(frozen.with_name("tiny-v1.sealed")).seeds == _SEEDS


def test_seeds_come_from_the_system_and_are_kept_by_a_run_that_goes_on(tmp_path: Path) -> None:
    first, other = (seeds_of(tmp_path / name, list(_LAYOUTS)) for name in ("a", "b"))
    assert len({*first.values(), *other.values()}) == 4
    assert seeds_of(tmp_path / "a", list(_LAYOUTS)) == first
