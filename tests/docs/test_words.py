"""Each pattern of the glossary's lint finds its example and leaves the other; at most 70 terms, 15 allowed places."""

import re
from pathlib import Path

import pytest

from docs.lint.words import Pattern, table

ROOT = Path(__file__).resolve().parents[2]
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
