import re
import shutil
import subprocess
import sys
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from tests.evaluation.made_dataset import estimates_of, make_dataset, write_estimates
from tests.evaluation.pallet import random_motion
from warehouse_sim.errors import EvaluationError
from warehouse_sim.evaluation import evaluate, write_scores
from warehouse_sim.evaluation.report import write_report

CURVES = "step,seconds,train_loss,val_within_5_percent\n0,1.0,,0.0\n10,61.0,0.5,40.0\n20,121.0,0.25,80.0\n"


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
    inputs = [folders / "data", folders / "run", folders / "good" / "eval", folders / "noisy" / "eval"]
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


def test_a_folder_of_folders_is_looked_into(folders, tmp_path):
    words = " ".join(Page(write_report([folders], tmp_path / "all.html").read_text()).words)
    assert "Training: net" in words
    assert "Data: data" in words


@pytest.mark.parametrize("text", ["", "step,samples,lear", "step,loss\n1,0.5\n2,0.4", "step,lo\0\0\n1,0.5\n"])
def test_curves_that_were_lost_are_said_to_be(folders, tmp_path, text):
    run = shutil.copytree(folders / "run", tmp_path / "run")
    (run / "curves.csv").write_text(text)
    with pytest.raises(EvaluationError, match=r"curves\.csv is empty or cut"):
        write_report([run], tmp_path / "x.html")


@pytest.mark.parametrize("text", ["7", "[1, 2]"])
def test_a_result_that_is_no_mapping_is_rejected(folders, tmp_path, text):
    run = shutil.copytree(folders / "run", tmp_path / "run")
    (run / "result.json").write_text(text)
    with pytest.raises(EvaluationError, match=r"result\.json: expected a mapping"):
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


def test_scoring_loads_no_heavy_package():
    heavy = "matplotlib, torch, mujoco, moderngl, embreex, open3d, jinja2"
    code = (
        "import sys, warehouse_sim.evaluation, warehouse_sim.evaluation.report\n"
        f"loaded = [name for name in '{heavy}'.split(', ') if name in sys.modules]\n"
        "sys.exit(str(loaded) if loaded else 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("constant", ["NaN", "Infinity", "-Infinity"])
def test_a_result_that_is_no_number_is_rejected(folders, tmp_path, constant):
    run = shutil.copytree(folders / "run", tmp_path / "run")
    (run / "result.json").write_text(f'{{"val_median_mm": {constant}}}')
    with pytest.raises(EvaluationError, match=f"result.json: {constant} is no number"):
        write_report([run], tmp_path / "report.html")
