import base64
import re
import shutil
from dataclasses import replace
from html.parser import HTMLParser

import cv2
import numpy as np
import pytest

from tests.evaluation.made_dataset import estimates_of, make_dataset, write_estimates
from tests.evaluation.pallet import nudge, random_motion
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.stored.contents import ChannelContents, ReadingContents
from warehouse_sim.errors import EvaluationError
from warehouse_sim.evaluation import evaluate, write_scores
from warehouse_sim.evaluation.report import write_report
from warehouse_sim.evaluation.report.images import (
    ESTIMATE_COLOR,
    GT_COLOR,
    close_up,
    depth_frame,
    frame_with_boxes,
    jpeg_uri,
)
from warehouse_sim.evaluation.report.page import reading_rows, render
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


class Page(HTMLParser):
    """Collects tags and text, and checks that every opened element is closed in order."""

    VOID = frozenset({"meta", "img", "br"})

    def __init__(self, text):
        super().__init__()
        self.tags, self.attributes, self.words, self._open = [], [], [], []
        self.feed(text)
        assert self._open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs
        if tag not in self.VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs

    def handle_endtag(self, tag):
        assert self._open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


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
    assert out.stat().st_size < 6e6
    outside = [v for k, v in page.attributes if k in ("src", "href", "xlink:href") and not v.startswith(("data:", "#"))]
    assert outside == []
    assert not re.search(r"url\((?!#)|@import", text)
    assert page.tags.count("svg") == 2 + 2 * 5 + 2
    images = [value for name, value in page.attributes if name == "src"]
    assert len(images) == 8 + 9 + 10
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
    assert "<script>" not in text
    assert "100.0" in words


def test_the_same_folders_give_the_same_page(folders, tmp_path):
    inputs = [folders / "data", folders / "noisy" / "eval"]
    first, second = (write_report(inputs, tmp_path / name).read_bytes() for name in ("a.html", "b.html"))
    assert first == second


def test_a_dataset_or_a_run_alone_can_be_reported(folders, tmp_path):
    page = Page(write_report([folders / "data"], tmp_path / "data.html").read_text())
    assert (page.tags.count("svg"), sum(name == "src" for name, _ in page.attributes)) == (0, 8)
    page = Page(write_report([folders / "run"], tmp_path / "run.html").read_text())
    assert page.tags.count("svg") == 2


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
        ["ring", "ultrasonic_ring", "echoes", "any x 2", "int32", "–", "3 to 7"],
        ["ring", "ultrasonic_ring", "warm", "one number", "bool", "–", "0 to 1"],
        ["silent", "gas", "ppm", "any", "float64", "ppm", "–"],
    ]


def test_the_page_shows_the_table_of_a_dataset_that_has_such_sensors() -> None:
    data = {"name": "d", "description": "", "facts": {"Recipe": "r", "Seed": 0}, "frames": [], "recipe": "{}"}
    nothing_else = {"scores": [], "comparison": [], "evaluations": [], "runs": []}
    without = render(datasets=[{**data, "readings": []}], **nothing_else)
    page = render(datasets=[{**data, "readings": reading_rows(DESCRIBED, [given(0.25, 3)])}], **nothing_else)
    assert "<td>ultrasonic_ring</td><td>distance</td><td>8</td><td>float32</td><td>m</td><td>0.25 to 4</td>" in page
    assert "<th>Sensor</th>" not in without


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    return DatasetReader(make_dataset(tmp_path_factory.mktemp("made") / "data", scenes=2))


def near(image, color, tolerance=30):
    """Pixels that have nearly the colour."""
    return np.abs(image.astype(int) - color).max(axis=2) <= tolerance


def case(data, index=1):
    image = data.images("test")[0]
    target = image.targets[index]
    return image, target, data.objects[target.obj_id]


def test_a_close_up_shows_both_poses_where_they_are(data):
    image, target, info = case(data)
    estimate = target.T_camera_object @ nudge(z=0.25)
    black = np.zeros((image.camera.height, image.camera.width, 3), np.uint8)
    crop = close_up(black, image.camera, info, target.T_camera_object, estimate)
    assert crop.shape == (300, 480, 3)
    gt_rows, estimate_rows = (np.flatnonzero(near(crop, c).any(axis=1)) for c in (GT_COLOR, ESTIMATE_COLOR))
    assert estimate_rows.min() < gt_rows.min()
    assert estimate_rows.max() < gt_rows.max()


def test_a_miss_has_no_orange(data):
    image, target, info = case(data)
    black = np.zeros((image.camera.height, image.camera.width, 3), np.uint8)
    crop = close_up(black, image.camera, info, target.T_camera_object, None)
    assert near(crop, GT_COLOR).sum() > 200
    assert not near(crop, ESTIMATE_COLOR).any()


def test_the_drawn_box_encloses_the_object_in_the_image(data):
    image, target, info = case(data, index=2)
    crop = close_up(
        np.repeat(data.mask(image, target.gt_index)[..., None] * np.uint8(255), 3, axis=2),
        image.camera, info, target.T_camera_object, None,
    )  # fmt: skip
    sampled = np.argwhere(near(crop, GT_COLOR))
    white = np.argwhere(near(crop, (255, 255, 255), 60))
    assert (sampled.min(axis=0) <= white.min(axis=0) + 3).all()
    assert (sampled.max(axis=0) >= white.max(axis=0) - 3).all()
    assert (np.abs(sampled.min(axis=0) - white.min(axis=0)) < 12).all()


def test_an_estimate_behind_the_camera_still_gives_an_image(data):
    image, target, info = case(data)
    behind = target.T_camera_object.copy()
    behind[2, 3] = -3.0
    assert close_up(data.rgb(image), image.camera, info, target.T_camera_object, behind).shape == (300, 480, 3)


def test_frames_have_the_width_requested_for(data):
    image = data.images("test")[0]
    assert frame_with_boxes(data, image, 640).shape == (240, 640, 3)
    assert near(frame_with_boxes(data, image, 640), GT_COLOR).sum() > 300
    assert depth_frame(data, image, 160).shape == (60, 160, 3)


def test_a_jpeg_uri_holds_the_image():
    image = np.zeros((20, 30, 3), np.uint8)
    image[..., 0] = 200
    uri = jpeg_uri(image)
    assert uri.startswith("data:image/jpeg;base64,")
    back = cv2.imdecode(np.frombuffer(base64.b64decode(uri.split(",")[1]), np.uint8), cv2.IMREAD_COLOR)
    assert np.abs(back[..., ::-1].astype(int) - image).max() <= 6
