"""The page of a dataset: which frames it shows, what is in them, and how it is served."""

import base64
import threading
from dataclasses import replace
from pathlib import Path
from urllib.error import HTTPError
from urllib.request import urlopen

import cv2
import numpy as np
import pytest

from tests.dataset.toy import make_dataset, make_manifest
from tests.pages import Page, needs_nothing_else, opened
from warehouse_sim.cli.main import main
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.viewing.page.arrays import depth_of, outline, picture_of
from warehouse_sim.dataset.viewing.page.dataset import dataset_page, served
from warehouse_sim.dataset.viewing.page.gallery import Answer, Shown, _trail, choose, gallery
from warehouse_sim.errors import InputError
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.lens import Distortion


@pytest.fixture(scope="module")
def reader(tmp_path_factory: pytest.TempPathFactory) -> DatasetReader:
    return DatasetReader(make_dataset(tmp_path_factory.mktemp("page") / "data", make_manifest(formats=("bop", "ply"))))


def many(reader: DatasetReader, count: int) -> Shown:
    """One image again and again, each a metre farther and seen less than the one before."""
    image = next(item for item in reader.images("all") if item.targets)
    target, images = image.targets[0], []
    for number in range(count):
        T = target.T_camera_object.copy()
        T[2, 3] = 1.0 + number
        moved = replace(target, T_camera_object=T, visible_fraction=1.0 - number / count)
        images.append(replace(image, image_id=number, targets=(moved,)))
    return Shown(reader, images)


def decoded(uri: str) -> np.ndarray:
    return cv2.imdecode(np.frombuffer(base64.b64decode(uri.partition(",")[2]), np.uint8), cv2.IMREAD_UNCHANGED)


def test_of_few_frames_all_are_there_and_of_many_the_worst_and_a_sample(reader: DatasetReader) -> None:
    shown = many(reader, 40)
    everything, words = choose(shown, {}, 40)
    assert ([image.image_id for image in everything], words) == (list(range(40)), "all 40 frames are here")
    label = (shown.images[3].scene_id, 3, shown.images[3].targets[0].gt_index)
    wrong = replace(shown, answers={"net": {label: Answer(None, "missed", "no estimate", np.inf)}})
    chosen, words = choose(wrong, {}, 15)
    places = [image.image_id for image in chosen]
    assert len(set(places)) == 15
    assert places == sorted(places)
    assert 3 in places, "the only failure"
    assert set(range(32, 40)) <= set(places), "the farthest, and then those seen least"
    assert words.startswith("15 of 40 frames are here: up to 4 worst by each of failure, distance, visibility, and")
    assert choose(wrong, {}, 15)[0] == chosen
    others = set(places) - {3} - set(range(32, 40))
    assert len(others) == 6, "sampled"


def test_frames_are_shared_out_so_that_small_datasets_are_whole(reader: DatasetReader) -> None:
    images = reader.images("all")
    shown = [Shown(reader, images), Shown(reader, images[:1]), Shown(reader, images[:5])]
    assert len(gallery(shown)["frames"]) == len(gallery(shown, None)["frames"]) == 12
    few = gallery(shown, 7)
    assert len(few["frames"]) == 7
    assert [part.partition(" frames")[0] for part in few["chosen"].split("data: ")[1:]] == ["3 of 6", "all 1", "3 of 5"]


def test_depth_on_the_page_is_the_depth_of_the_dataset(reader: DatasetReader) -> None:
    image = reader.images("all")[0]
    found = depth_of(reader, image, 10**6)
    assert found is not None
    planes = decoded(found["png"]).astype(int)
    high, low = np.split(planes, 2)
    steps, (nearest, farthest, last) = 16 * high + low, found["scale"]
    metres = np.where(steps > 0, nearest * (farthest / nearest) ** ((steps - 1) / (last - 1)), 0.0)
    fx, fy, cx, cy = found["camera"]
    v, u = np.indices(metres.shape)
    rays = np.stack([(u - cx) / fx, (v - cy) / fy, np.ones(u.shape)], axis=-1)
    pixels = np.round(image.camera.project(rays)).astype(int)
    inside = ((pixels >= 0) & (pixels < [image.camera.width, image.camera.height])).all(axis=-1)
    true = reader.depth(image)[pixels[inside][:, 1], pixels[inside][:, 0]]
    close = np.isclose(metres[inside], true, rtol=2e-3)
    assert close.mean() > 0.98, "what lies between two pixels may be either"
    assert (true > 0).mean() > 0.4
    assert decoded(found["pixels"]).shape[:2] == metres.shape


def test_behind_a_lens_outlines_bend_and_what_a_camera_cannot_see_has_none(reader: DatasetReader) -> None:
    camera = reader.images("all")[0].camera
    corners = box_corners(np.array([1.0, 0.5, 0.5])) + np.array([0.0, 0.0, 2.0])
    straight, bent = (outline(item, corners) for item in (camera, replace(camera, distortion=Distortion(-0.1, 0.01))))
    assert straight.count("M") == bent.count("M") == 12
    assert straight.count("L") == 12 < bent.count("L")
    ends = np.array([point.split() for point in straight[1:].replace("M", "L").split("L")], float)
    apart = np.linalg.norm(ends[:, None] - camera.project(corners), axis=-1)
    assert apart.min(axis=1).max() < 0.8
    assert apart.min(axis=0).max() < 0.8
    assert outline(camera, corners - np.array([0.0, 0.0, 9.0])) == ""


def test_pictures_keep_to_their_budget_where_they_can(reader: DatasetReader) -> None:
    image = reader.images("all")[0]
    rich, poor = (picture_of(reader, image, budget) for budget in (10**6, 1))
    assert len(poor) <= len(rich)
    assert decoded(rich).shape[1] == min(640, image.camera.width)
    assert np.abs(decoded(rich)[..., ::-1].astype(int).mean() - reader.rgb(image).mean()) < 3


def test_an_object_has_its_tags_its_corners_and_its_way(reader: DatasetReader) -> None:
    first, second = reader.images("train")
    ahead = np.eye(4)
    ahead[2, 3] = 0.5
    second = replace(second, T_world_camera=first.T_world_camera @ ahead)
    images = [first, second]
    for frame, image in zip(gallery([Shown(reader, images)])["frames"], images, strict=True):
        np.testing.assert_allclose(np.diff(frame["way"], axis=0), [[0.0, 0.0, 0.5]], atol=2e-3)
        assert frame["sweep"] is not None
        for item, target in zip(frame["objects"], image.targets, strict=True):
            assert item["tags"]["class"] == target.info(reader.objects).class_name
            low, _, high = item["tags"]["distance"].removesuffix(" m").partition(" - ")
            assert float(low) <= np.linalg.norm(target.T_camera_object[:3, 3]) <= float(high)
            np.testing.assert_allclose(np.mean(item["corners"], axis=0), target.T_camera_object[:3, 3], atol=2e-3)


def test_what_moves_in_a_scene_has_its_way_in_the_frame_of_the_camera(reader: DatasetReader) -> None:
    images = [item for item in reader.images("all") if item.targets][:1]
    first, target = images[0], images[0].targets[0]
    T = target.T_camera_object.copy()
    T[0, 3] += 0.4
    later = replace(first, image_id=99, targets=(replace(target, T_camera_object=T), *first.targets[1:]))
    frame, *_ = gallery([Shown(reader, [first])])["frames"]
    assert frame["objects"][0]["way"] == []
    by_scene = [first, later]
    ways = [_trail(first, item, by_scene) for item in first.targets]
    np.testing.assert_allclose(np.diff(ways[0], axis=0), [[0.4, 0.0, 0.0]], atol=2e-3)
    assert ways[1:] == [[]] * (len(ways) - 1), "what stands has none"


def test_the_command_writes_a_page_that_a_browser_opens(reader: DatasetReader, tmp_path: Path) -> None:
    out = tmp_path / "sub" / "d.html"
    assert main(["view", str(reader.root), "--html", str(out)]) == 0
    text = out.read_text(encoding="utf-8")
    needs_nothing_else(text)
    assert len(Page(text).frames) == 6
    assert main(["view", str(reader.root), "--html", str(tmp_path / "e.html"), "--limit", "2"]) == 0
    assert len(Page((tmp_path / "e.html").read_text()).frames) == 2
    with opened(out) as page:
        page.locator("#frames figure").first.wait_for()
        assert page.locator("#frames figure").count() == 6
        page.locator("#frames figure").nth(1).press("Enter")
        assert page.locator("#frame h3").inner_text() == "data, train 0/1"
        page.wait_for_selector("#space canvas", timeout=60_000)
        names = page.evaluate("document.getElementById('space').data.map(item => item.name)")
        assert {"ground truth", "LiDAR", "cloud"} <= set(names)
        page.locator("#depth .main-svg").first.wait_for(timeout=60_000)


def test_the_page_is_served_on_the_loopback_address_alone(reader: DatasetReader) -> None:
    page = dataset_page(reader, reader.images("train"))
    with served(page, 0) as server:
        host, port = server.server_address[:2]
        assert host == "127.0.0.1"
        threading.Thread(target=server.serve_forever, daemon=True).start()
        with urlopen(f"http://{host}:{port}/") as answer:
            assert answer.read() == page
        with pytest.raises(HTTPError, match="404"):
            urlopen(f"http://{host}:{port}/manifest.json")
        with pytest.raises(InputError, match=rf"--port {port}: cannot be listened on"), served(page, int(port)):
            pass
        server.shutdown()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--html", "d.rrd"], "is written as .html or .htm"),
        (["--html", "d.html", "--save", "d.rrd"], "--save and --html are different ways"),
        (["--web", "--summary"], "--web and --summary are different ways"),
        (["--web", "--port", "70000"], "--port must be 0 to 65535"),
    ],
)
def test_what_makes_no_sense_is_rejected(
    reader: DatasetReader, capsys: pytest.CaptureFixture[str], arguments: list[str], words: str
) -> None:
    assert main(["view", str(reader.root), *arguments]) == 2
    assert words in capsys.readouterr().err
