"""Links, anchors, paths and commands of the pages lead somewhere; README is short; numbers are those of the results."""

import importlib
import importlib.util
import re
from pathlib import Path

import pytest

from docs.lint.words import Pattern, table
from docs.numbers.insert import inserted, tables
from warehouse_sim.benchmark.rows.simulated import CLOSED_LOOPS, SIMULATIONS
from warehouse_sim.catalog import CATALOG
from warehouse_sim.cli.commands import COMMANDS
from warehouse_sim.dataset.formats import FORMATS
from warehouse_sim.estimators.registries import DETECTORS, ESTIMATORS, FAMILIES, SEGMENTERS
from warehouse_sim.render import BACKENDS
from warehouse_sim.sensors import SENSORS

ROOT = Path(__file__).resolve().parents[2]
PATTERNS = (
    "*.md", "docs/*.md", "docs/tutorials/*.md", "models/**/*.md", "scenes/*.md", "benchmarks/*.md", "examples/**/*.md",
)  # fmt: skip
PAGES = sorted(path for pattern in PATTERNS for path in ROOT.glob(pattern) if path.name != "CHANGELOG.md")
_LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
_FOLDERS = "tests|docs|benchmarks|trainings|warehouse_sim|scenes|models|examples|locks"
_PATH = re.compile(rf"(?<![\w/.-])((?:{_FOLDERS})/[\w./-]*\w\.(?:py|md|yaml|json|jpg|png|txt|toml))\b")
_DOTTED = re.compile(r"`(warehouse_sim(?:\.\w+)+)`")
WRITTEN = (ROOT / "docs" / "leaderboards.md", ROOT / "docs" / "dissertation.md")
_IN_DATASETS = ("scenes/000000.json",)
_MODULE = re.compile(r"python -m ((?:benchmarks|docs|locks|tests|trainings|warehouse_sim)[\w.]*)")
_COMMAND = re.compile(r"warehouse-sim ([a-z][a-z-]*)\b")


def anchors(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as GitHub makes them."""
    heads = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).strip().replace(" ", "-") for head in heads}


def groups() -> set[str]:
    """Return the entry-point groups of all registries."""
    registries = (ESTIMATORS, DETECTORS, SEGMENTERS, FAMILIES, FORMATS, SENSORS, BACKENDS, CATALOG)
    return {item.group for item in registries} | {SIMULATIONS.group, CLOSED_LOOPS.group}


def found(name: str) -> bool:
    """Return whether a dotted name is a module, or something in one."""
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        try:
            place = importlib.import_module(".".join(parts[:count]))
        except ModuleNotFoundError:
            continue
        for part in parts[count:]:
            if not hasattr(place, part):
                return False
            place = getattr(place, part)
        return True
    return False


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_of_a_page_lead_somewhere(page: Path) -> None:
    text, dead = page.read_text(encoding="utf-8"), []
    for link in _LINK.findall(text):
        place, _, anchor = link.partition("#")
        if re.match(r"[a-z]+:", link):
            continue
        target = (page.parent / place).resolve() if place else page
        if not target.exists() or (anchor and target.suffix == ".md" and anchor not in anchors(target)):
            dead.append(link)
    dead += [path for path in _PATH.findall(text) if not (ROOT / path).exists() and path not in _IN_DATASETS]
    dead += [name for name in _DOTTED.findall(text) if not found(name) and name not in groups()]
    for name in _MODULE.findall(text):
        if importlib.util.find_spec(name.rstrip(".")) is None:
            dead.append(f"python -m {name}")
    dead += [f"warehouse-sim {name}" for name in _COMMAND.findall(text) if name not in COMMANDS]
    assert dead == []


def test_all_pages_together_are_short() -> None:
    """Rules of tables are no words, and pages that a command writes do not count."""
    pages = [path for path in (ROOT / "docs").rglob("*.md") if "generated" not in path.parts]
    texts = [path.read_text(encoding="utf-8") for path in pages if path not in WRITTEN]
    assert sum(bool(re.search(r"\w", word)) for text in texts for word in text.split()) <= 45_000


def test_the_readme_is_short() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(text.split("## Links")[0].split()) <= 700
    assert len(text.split("```")[0].split()) <= 60


@pytest.mark.parametrize("name", sorted(tables()))
def test_numbers_are_those_of_the_stored_results(name: str) -> None:
    table = tables()[name]
    text = (ROOT / table.page).read_text(encoding="utf-8")
    assert inserted(text, name, table.text()) == text, "run python -m docs.numbers.insert"


def test_the_worst_case_of_the_readme_stands_first() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    shown = [float(number) for number in re.findall(r"\*\*([\d.]+) %\*\*", text)]
    assert len(shown) >= 5
    assert shown == sorted(shown)


# Each pattern of the glossary's lint finds its example and leaves the other; at most 70 terms, 15 allowed places.


PATTERNS, ALLOWED = table()


@pytest.mark.parametrize("pattern", PATTERNS, ids=lambda pattern: pattern.catch)
def test_a_pattern_finds_its_example_and_leaves_the_other(pattern: Pattern) -> None:
    assert pattern.found_in(pattern.catch)
    assert not pattern.found_in(pattern.leave)


def test_the_glossary_is_short_and_sorted() -> None:
    text = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8")
    terms = [term.strip("`").lower() for term in re.findall(r"^\| (.+?) \|", text, re.MULTILINE)[1:]]
    assert 30 <= len(terms) <= 70
    assert len(set(terms)) == len(terms)


def test_allowed_places_are_few_and_there() -> None:
    assert len(ALLOWED) <= 15
    for item in ALLOWED:
        assert item.reason
        assert (ROOT / item.path).exists()


def test_phrases_are_read_over_the_end_of_a_line() -> None:
    truth = next(pattern for pattern in PATTERNS if pattern.catch == "the truth of the image")
    assert not truth.ends_after("ground", "truth is measured")
    assert truth.ends_after("the", "truth is measured")
    assert not truth.ends_after("truth", "is measured"), "reported with the line before"
    pattern = next(pattern for pattern in PATTERNS if pattern.catch == "the lux asked for")
    assert pattern.ends_after("asked", "for by a recipe")
