"""Cards and the table of the bundled weights are those of the stored results."""

import re
import shutil
from pathlib import Path

import pytest

from trainings import cards
from trainings.headline import Headline
from warehouse_sim.resources import data_folder, model_dir, model_names
from warehouse_sim.yaml_file import read_yaml

NAMES = [name for name in model_names() if not name.endswith(cards.BY_LAYOUT)]
RENEW = "python -m trainings.cards"


@pytest.mark.parametrize("name", NAMES)
def test_a_card_is_that_of_the_stored_results(name: str, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(model_dir(name), tmp_path / name))
    files = sorted(folder.glob("card.*"))
    before = [path.read_bytes() for path in files]
    cards.write(folder)
    assert sorted(folder.glob("card.*")) == files
    assert before == [path.read_bytes() for path in files], RENEW


@pytest.mark.parametrize("name", model_names())
def test_every_bundled_weight_has_a_score(name: str) -> None:
    card = read_yaml(model_dir(name) / "card.yaml")
    assert re.search(r"\d\.\d %", card["score"])


def test_a_new_headline_stands_in_both_cards_beside_the_scores(tmp_path: Path) -> None:
    folder = Path(shutil.copytree(model_dir("densefusion-depth"), tmp_path / "densefusion-depth"))
    stored = read_yaml(folder / "card.yaml")
    cards.write(folder, Headline(0.12345, 678))
    card = read_yaml(folder / "card.yaml")
    assert card["headline"] == stored["headline"] | {"fraction": 0.1235, "count": 678}
    assert card | {"headline": 0} == stored | {"headline": 0}
    assert "12.3 % of 678 pallets" in (folder / "card.md").read_text(encoding="utf-8")


def test_the_table_is_that_of_the_stored_results(tmp_path: Path) -> None:
    stored = data_folder("models") / "README.md"
    copy = Path(shutil.copy(stored, tmp_path / "README.md"))
    cards.write_table(copy)
    assert copy.read_bytes() == stored.read_bytes(), RENEW


def test_a_page_without_a_place_for_the_table_is_an_error(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(f"before\n<!-- table: {cards.COMMAND} -->\nno end\n")
    with pytest.raises(ValueError, match=r"page\.md: has no lines"):
        cards.write_table(page)


def test_a_number_of_a_suite_stands_in_the_card_and_the_table() -> None:
    row = next(
        row
        for row in cards.suites()["industrial"].rows
        if (row.estimator, row.group, row.metric) == ("densefusion-depth+verify", "all", "dock_0mm")
    )
    low, high = row.interval
    cell = f"{100 * row.value:.1f} [{100 * low:.0f}, {100 * high:.0f}]"
    for path in (model_dir("densefusion-depth") / "card.md", data_folder("models") / "README.md"):
        lines = path.read_text(encoding="utf-8").splitlines()
        assert any(cell in line for line in lines if "densefusion-depth+verify" in line), path


def test_what_no_result_scores_has_no_card() -> None:
    with pytest.raises(SystemExit, match="detector-new: no stored result scores it"):
        cards._of_front_end("detector-new")
