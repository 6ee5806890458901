import shutil
from pathlib import Path

import cv2
import numpy as np

from tests.dataset.toy import make_scene, observe
from warehouse_sim.dataset.card.text import OWNERS, data_licences, licence_text, measure
from warehouse_sim.dataset.card.thumbnails import shown_observations
from warehouse_sim.dataset.convert.run import convert


def test_the_card_says_what_the_images_show(toy_root: Path) -> None:
    text = (toy_root / "README.md").read_text()
    labels = [
        sum(item.pixels_visible > 0 for observation in observe(make_scene(index)) for item in observation.annotations)
        for index in range(3)
    ]
    assert f"| labels | {sum(labels)} |" in text
    assert f"| pallet | {sum(labels)} | 9 | 9 | 1 | 1 | 0 | 1 | 1 |" in text
    assert "| all | 3 | 6 |" in text
    for heading in ("Licence", "How to make it again", "Limits", "How large it is", "What is in it"):
        assert f"## {heading}" in text
    assert "Not stated by who made it." in text  # a toy's manifest has no licences


def test_thumbnails_are_the_images_in_small(toy_root: Path) -> None:
    shown = shown_observations(3, 2)
    assert shown == [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)]
    for scene, observation in shown:
        small = cv2.imread(str(toy_root / f"card/{scene:06d}_{observation:06d}.jpg"))[..., ::-1]
        rgb = cv2.resize(observe(make_scene(scene))[observation].rgbd.rgb, (320, 192))
        assert np.abs(small.astype(float) - rgb).mean() < 12  # the toy's images are stripes, hard on JPEG
    assert cv2.imread(str(toy_root / "card/thumbnails.jpg")).shape == (2 * 196 + 4, 4 * 324 + 4, 3)


def test_thumbnails_are_spread_over_the_dataset() -> None:
    shown = shown_observations(1000, 12)
    assert len(set(shown)) == len(shown) == 12
    assert shown[0] == (0, 0)
    assert shown[-1][0] > 900


def test_bytes_are_those_that_the_system_counts(toy_root: Path) -> None:
    names = ["kitti", "bop", "scenes"]
    found = measure(toy_root, [*names, "none"])
    files = {name: [path.stat() for path in (toy_root / name).rglob("*") if path.is_file()] for name in names}
    assert found.by_folder == {name: sum(item.st_size for item in files[name]) for name in names}
    once = {item.st_ino: item.st_size for name in names for item in files[name]}
    size = sum(once.values())
    assert found.together == size < sum(found.by_folder.values())
    assert (
        f"| together, files that formats share counted once | {size / 1e6:,.1f} | {size / 6e3:,.1f} |"
        in (toy_root / "README.md").read_text()
    )


def test_what_users_brought_is_theirs() -> None:
    licences = data_licences("CC0-1.0", ["own/trolley.yaml"], ["flat-rays"])
    assert licences == {
        "data": "Apache-2.0",
        "textures": "CC0-1.0",
        "own/trolley.yaml": OWNERS,
        "plug-in flat-rays": OWNERS,
    }
    assert "bound to what their owners allow" in licence_text(licences)
    assert "bound to" not in licence_text(data_licences("CC0-1.0", [], []))


def test_a_converted_dataset_says_so(toy_root: Path, tmp_path: Path) -> None:
    shutil.copytree(toy_root / "bop", tmp_path / "theirs")
    convert(tmp_path / "theirs", tmp_path / "data", ["bop_webdataset"])
    text = (tmp_path / "data/README.md").read_text()
    assert "| converted from | theirs |" in text
    assert "- data: as its owner says" in text
    assert "warehouse-sim convert theirs --to bop_webdataset --out ../again" in text
    assert "GB for 1,000 observations" in text
    assert not (tmp_path / "data/card/recipe.yaml").exists()
    assert len(list((tmp_path / "data/card").glob("*_*.jpg"))) == 6


def test_links_within_a_folder_and_between_two_count_once(tmp_path: Path) -> None:
    for name in ("a/deep", "b"):
        (tmp_path / name).mkdir(parents=True)
    (tmp_path / "a/one").write_bytes(bytes(1000))
    (tmp_path / "b/two").write_bytes(bytes(50))
    for name in ("a/deep/one", "b/one"):
        (tmp_path / name).hardlink_to(tmp_path / "a/one")
    found = measure(tmp_path, ["a", "b", "none"])
    assert found.by_folder == {"a": 1000, "b": 1050}
    assert found.together == 1050
