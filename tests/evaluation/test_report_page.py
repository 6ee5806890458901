import csv
import io
import shutil
from dataclasses import replace

import cv2
import numpy as np
import pytest

from tests.dataset.kitti_folder import HEIGHT, WIDTH, write_street
from tests.evaluation.made_dataset import estimates_of, make_dataset, write_estimates
from tests.evaluation.pallet import random_motion
from tests.pages import Page, needs_nothing_else, opened
from warehouse_sim.dataset.results import predictions
from warehouse_sim.dataset.stored.contents import ChannelContents, ReadingContents
from warehouse_sim.dataset.viewing.page.gallery import gallery
from warehouse_sim.errors import EvaluationError, WarehouseSimError
from warehouse_sim.evaluation import evaluate, read_scores, write_scores
from warehouse_sim.evaluation.report import reading_rows, render, write_report
from warehouse_sim.evaluation.trust import succeeded
from warehouse_sim.schema import ChannelReading, MountedReading

CURVES = "step,seconds,train_loss,val_within_5_percent\n0,1.0,,0.0\n10,61.0,0.5,40.0\n20,121.0,0.25,80.0\n"
RING = {
    "distance": ChannelContents("<f4", (8,), "m"),
    "echoes": ChannelContents("<i4", (None, 2)),
    "warm": ChannelContents("|b1", ()),
}
DESCRIBED = {
    "ring": ReadingContents("ultrasonic_ring", RING),
    "silent": ReadingContents("gas", {"ppm": ChannelContents("<f8", (None,), "ppm")}),
}


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """A folder with a dataset, a run, and two evaluations of the same method."""
    root = tmp_path_factory.mktemp("all")
    data = make_dataset(root / "data")
    rng = np.random.default_rng(3)
    estimates = estimates_of(data)
    noisy = [
        replace(item, T_camera_object=item.T_camera_object @ random_motion(rng, 0.03, 0.03)) for item in estimates[1:]
    ]
    for name, rows in {"good": estimates, "noisy": noisy}.items():
        scores = evaluate(write_estimates(rows, root / name / "net_x.csv"), data, "test")
        write_scores(scores, root / name / "eval")
    run = root / "run"
    run.mkdir()
    (run / "curves.csv").write_text(CURVES)
    (run / "config.yaml").write_text("estimator: net\nsecret: <script>\n")
    (run / "result.json").write_text('{"parameters": 1234}')
    return root


def test_the_page_is_whole_small_and_needs_nothing_else(folders, tmp_path):
    # A folder of folders is looked into.
    inputs = [folders, folders / "good" / "eval", folders / "noisy" / "eval"]
    out = write_report(inputs, tmp_path / "sub" / "report.html")
    text = out.read_text(encoding="utf-8")
    page = Page(text)
    assert out.stat().st_size < 5e6
    needs_nothing_else(text)
    assert len(page.figures) == 2 + 2 * 5 + 2
    assert sum(name == "src" for name, _ in page.attributes) == 9 + 10, "close-ups of both evaluations"
    assert [frame["name"] for frame in page.frames] == ["test 2/0", "test 2/1", "test 3/0", "test 3/1"]
    words = " ".join(page.words)
    for expected in [
        "net (good/eval)",
        "net (noisy/eval)",
        "no estimate",
        "By distance",
        "made, seed 0",
        "pallets as flat amodal masks",
        "1234",
        "Training: net",
        "Data: data",
    ]:
        assert expected in words
    assert "secret: <script>" not in text
    assert "100.0" in words


def test_the_gallery_knows_what_each_method_says_of_each_object(folders, tmp_path):
    inputs = [folders / "data", folders / "good" / "eval", folders / "noisy" / "eval"]
    page = Page(write_report(inputs, tmp_path / "report.html").read_text(encoding="utf-8"))
    scores = {name: read_scores(folders / name / "eval") for name in ("good", "noisy")}
    failures = {name: [] for name in scores}
    for frame in page.frames:
        for item in frame["objects"]:
            for name, found in failures.items():
                answer = item["answers"].get(f"net ({name}/eval)")
                if answer is not None:
                    found.append(answer["failure"])
                    assert bool(answer["path"]) == bool(answer["corners"]) == (answer["failure"] != "missed")
    assert set(failures["good"]) == {"right"}
    assert len(failures["good"]) == len(failures["noisy"]) == len(scores["noisy"].table)
    assert failures["noisy"].count("missed") == int((~scores["noisy"].table.found).sum()) > 0
    assert failures["noisy"].count("right") == int(succeeded(scores["noisy"].table).sum())


def test_each_number_has_the_command_that_gives_it_and_a_method_its_name(folders, tmp_path):
    data, estimates = folders / "data", estimates_of(folders / "data")
    predictions.write(tmp_path / "p.csv", estimates, predictions.Origin("my-net", "warehouse-sim predict my-net"))
    scores = evaluate(tmp_path / "p.csv", data, "test")
    assert (scores.method, scores.predicted_by) == ("my-net", "warehouse-sim predict my-net")
    write_scores(scores, tmp_path / "found")
    assert read_scores(tmp_path / "found").predicted_by == scores.predicted_by
    words = " ".join(Page(write_report([data, tmp_path / "found"], tmp_path / "r.html").read_text()).words)
    assert "warehouse-sim generate recipe.yaml --seed 0 --scenes 4 --formats bop --out data" in words
    assert "warehouse-sim predict my-net" in words
    assert "warehouse-sim evaluate found/predictions.csv --data data --split test --out found" in words
    predictions.write(tmp_path / "p.csv", estimates)
    assert evaluate(tmp_path / "p.csv", data, "test").method == "p", "an older statement goes with its file"


def test_a_browser_sorts_filters_saves_and_turns(folders, tmp_path):
    inputs = [folders / "data", folders / "good" / "eval", folders / "noisy" / "eval"]
    out = write_report(inputs, tmp_path / "report.html")
    frames = Page(out.read_text(encoding="utf-8")).frames
    with opened(out) as page:
        head, cells = page.locator("main table th").nth(3), page.locator("main table").first.locator("td:nth-child(4)")
        values = lambda: [float(item) for item in cells.evaluate_all("all => all.map(cell => cell.dataset.value)")]  # noqa: E731
        head.click()
        assert values() == sorted(values(), reverse=True)
        head.click()
        assert values() == sorted(values())
        assert len(set(values())) == 2
        page.locator(".tools select").first.select_option(index=1)
        assert page.locator("main table").first.locator("tbody tr:visible").count() == 1
        table = page.locator("a.csv").first.evaluate(
            "link => decodeURIComponent(link.href.split(',').slice(1).join(','))"
        )
        rows = list(csv.DictReader(io.StringIO(table)))
        assert float(rows[0]["ADD <\u00a010\u00a0% d low".replace("\u00a0", " ")]) <= 100.0
        page.locator("#frames figure").first.wait_for()
        assert page.locator("#frames figure").count() == 4
        group = page.locator("table[data-groups='0'] tbody a").last
        far = float(group.inner_text().replace("over ", "").partition("-")[0])
        group.click()
        wanted = [frame for frame in frames if any(item["values"][0] >= far for item in frame["objects"])]
        assert page.locator("#frames figure").count() == len(wanted) > 0
        page.locator("#filters button").click()
        assert page.locator("#frames figure").count() == 4
        page.locator("select[name=failure]").select_option("missed")
        assert page.locator("#frames figure").count() == 1
        page.locator("#frames figure").click()
        assert page.locator("#frame figure").count() == 2, "methods side by side"
        page.wait_for_selector("#space canvas", timeout=60_000)
        eye = "document.getElementById('space').layout.scene.camera.eye"
        before = page.evaluate(eye)
        page.locator("#space").press("ArrowLeft")
        page.wait_for_function(f"{eye}.x !== {before['x']}")
        assert "cloud" in page.evaluate("document.getElementById('space').data.map(item => item.name)")
        page.keyboard.press("Escape")
        page.locator("#theme").click()
        assert page.evaluate("document.documentElement.dataset.theme") == "dark"
        page.locator(".chart").first.scroll_into_view_if_needed()
        page.wait_for_selector(".chart .main-svg", timeout=60_000)


def test_a_narrow_screen_does_not_scroll_sideways(folders, tmp_path):
    out = write_report([folders / "data", folders / "noisy" / "eval"], tmp_path / "report.html")
    with opened(out, width=400) as page:
        page.evaluate("scrollTo(0, document.body.scrollHeight)")
        page.wait_for_timeout(1000)
        assert page.evaluate("document.documentElement.scrollWidth") <= 400


def test_the_same_folders_give_the_same_page(folders, tmp_path):
    inputs = [folders / "data", folders / "noisy" / "eval"]
    first, second = (write_report(inputs, tmp_path / name).read_bytes() for name in ("a.html", "b.html"))
    assert first == second


def test_a_dataset_or_a_run_alone_can_be_reported(folders, tmp_path):
    page = Page(write_report([folders / "data"], tmp_path / "data.html").read_text())
    assert (page.figures, len(page.frames)) == ([], 8)
    page = Page(write_report([folders / "run"], tmp_path / "run.html").read_text())
    assert (len(page.figures), page.frames) == (2, [])


def test_a_folder_of_kitti_is_one_dataset(tmp_path):
    write_street(tmp_path / "street", 3, testing=1)
    for half, stored in (("training", 3), ("testing", 1)):  # such a folder looks like bare images
        (tmp_path / "street" / half / "depth_2").mkdir()
        for frame in range(stored):
            steps = np.full((HEIGHT, WIDTH), 2560, np.uint16)
            cv2.imwrite(str(tmp_path / "street" / half / "depth_2" / f"{frame:06d}.png"), steps)
    assert len(Page(write_report([tmp_path / "street"], tmp_path / "a.html").read_text()).frames) == 4
    assert len(Page(write_report([tmp_path], tmp_path / "b.html").read_text()).frames) == 4


def test_what_cannot_be_read_is_left_out_of_a_folder_of_folders_with_a_warning(folders, tmp_path, caplog):
    root = shutil.copytree(folders, tmp_path / "all")
    shutil.copytree(root / "data", root / "broken")
    next((root / "broken").rglob("scene_gt.json")).write_text("{")
    shutil.copytree(root / "data", root / "half")
    (root / "half" / "manifest.json").unlink()
    for name in ("rgb.png", "depth.png"):
        (root / "frames").mkdir(exist_ok=True)
        (root / "frames" / name).touch()
    (root / "cut").mkdir()
    (root / "cut" / "curves.csv").write_text("")
    page = Page(write_report([root], tmp_path / "all.html").read_text())
    assert (len(page.frames), len(page.figures)) == (8, 2)
    reasons = {"broken": "scene_gt.json", "half": "incomplete", "frames": "what the camera is", "cut": "the run cannot"}
    for name, words in reasons.items():
        (line,) = [item for item in caplog.messages if str(root / name) in item]
        assert line.startswith("left out: ")
        assert words in line
        with pytest.raises(WarehouseSimError, match=words):
            write_report([root / name], tmp_path / "x.html")


@pytest.mark.parametrize("text", ["", "step,samples,lear", "step,loss\n1,0.5\n2,0.4", "step,lo\0\0\n1,0.5\n"])
def test_curves_that_were_lost_are_said_to_be(folders, tmp_path, text):
    run = shutil.copytree(folders / "run", tmp_path / "run")
    (run / "curves.csv").write_text(text)
    with pytest.raises(EvaluationError, match=r"curves\.csv is empty or cut"):
        write_report([run], tmp_path / "x.html")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("7", "expected a mapping"),
        ("[1, 2]", "expected a mapping"),
        ('{"val_median_mm": NaN}', "NaN is no number"),
        ('{"val_median_mm": Infinity}', "Infinity is no number"),
        ('{"val_median_mm": -Infinity}', "-Infinity is no number"),
    ],
)
def test_a_result_that_is_no_mapping_of_numbers_is_rejected(folders, tmp_path, text, message):
    run = shutil.copytree(folders / "run", tmp_path / "run")
    (run / "result.json").write_text(text)
    with pytest.raises(EvaluationError, match=rf"result\.json: {message}"):
        write_report([run], tmp_path / "x.html")


def test_a_folder_in_place_of_a_result_is_rejected(folders, tmp_path):
    run = shutil.copytree(folders / "run", tmp_path / "run")
    (run / "result.json").unlink()
    (run / "result.json").mkdir()
    with pytest.raises(EvaluationError, match=r"result\.json"):
        write_report([run], tmp_path / "x.html")


def test_an_evaluation_needs_its_dataset(folders, tmp_path):
    other = make_dataset(tmp_path / "other", seed=5)
    with pytest.raises(EvaluationError, match=r"made, seed 0\) that is not among the folders given"):
        write_report([other, folders / "good" / "eval"], tmp_path / "x.html")


def test_a_folder_with_nothing_to_report_is_rejected(tmp_path):
    with pytest.raises(EvaluationError, match="holds no dataset"):
        write_report([tmp_path], tmp_path / "x.html")
    with pytest.raises(EvaluationError, match="there is nothing to report: name at least one"):
        write_report([], tmp_path / "x.html")
    with pytest.raises(EvaluationError, match="is not a folder"):
        write_report([tmp_path / "nowhere"], tmp_path / "x.html")


def given(nearest: float, echoes: int) -> dict[str, MountedReading[ChannelReading]]:
    distances = np.linspace(nearest, 4.0, 8, dtype=np.float32)
    arrays = {"distance": distances, "echoes": np.full((echoes, 2), echoes, np.int32), "warm": np.array(echoes > 1)}
    silent = {"ppm": np.zeros(0)}
    return {name: MountedReading(np.eye(4), ChannelReading(a)) for name, a in (("ring", arrays), ("silent", silent))}


def test_each_channel_is_a_row_with_the_range_over_all_observations() -> None:
    rows = reading_rows(DESCRIBED, [given(0.25, 3), given(1.5, 0), given(0.5, 7)])
    assert [list(row.values()) for row in rows] == [
        ["ring", "ultrasonic_ring", "distance", "8", "float32", "m", "0.25 to 4"],
        ["ring", "ultrasonic_ring", "echoes", "any x 2", "int32", "", "3 to 7"],
        ["ring", "ultrasonic_ring", "warm", "one number", "bool", "", "0 to 1"],
        ["silent", "gas", "ppm", "any", "float64", "ppm", ""],
    ]


def test_the_page_shows_the_table_of_a_dataset_that_has_such_sensors() -> None:
    data = {"name": "d", "description": "", "facts": {"Recipe": "r", "Seed": 0}, "recipe": "{}"}
    nothing_else = {"scores": [], "comparison": [], "evaluations": [], "runs": [], "frames": gallery([])}
    without = render(datasets=[{**data, "readings": []}], **nothing_else)
    page = render(datasets=[{**data, "readings": reading_rows(DESCRIBED, [given(0.25, 3)])}], **nothing_else)
    assert "<td>ultrasonic_ring</td><td>distance</td><td>8</td><td>float32</td><td>m</td><td>0.25 to 4</td>" in page
    assert "<th>Sensor</th>" not in without
