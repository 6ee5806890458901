"""The picture of the architecture is of the code: every room has its floor, and imports run down."""

import importlib
from pathlib import Path

import numpy as np
import pytest

from docs.figures.architecture import PACKAGE, ROOT, draw_architecture, floors, imports, lines_of
from docs.figures.color_difference import ciede2000, lab_from_srgb


def test_every_room_has_a_floor() -> None:
    places = (ROOT / PACKAGE).iterdir()
    rooms = {path.stem for path in places if path.suffix == ".py" or (path / "__init__.py").is_file()}
    assert rooms - {"__init__", "__main__"} == {room for floor in floors() for room in floor}
    assert all(lines_of(room) > 0 for floor in floors() for room in floor)


def test_imports_run_down() -> None:
    height = {room: index for index, floor in enumerate(floors()) for room in floor}
    found = imports()
    assert found["cli", "api"] or found["cli", "generation"]
    up = {pair for pair in found if set(pair) <= height.keys() and height[pair[0]] <= height[pair[1]]}
    assert up == set()


def test_it_is_drawn(tmp_path: Path) -> None:
    draw_architecture(tmp_path / "rooms.png")
    assert (tmp_path / "rooms.png").stat().st_size > 20_000


# Every script that draws the documentation's pictures, or writes its numbers, imports.


SCRIPTS = sorted(
    ".".join(path.relative_to(ROOT).with_suffix("").parts)
    for folder in ("figures", "lint", "numbers")
    for path in (ROOT / "docs" / folder).glob("*.py")
    if path.stem != "__init__"
)


def test_there_are_scripts() -> None:
    assert len(SCRIPTS) >= 12


@pytest.mark.parametrize("name", SCRIPTS)
def test_a_script_imports(name: str) -> None:
    assert importlib.import_module(name)


# Pairs of the supplementary data of Sharma, Wu & Dalal 2005.
PAIRS = (
    ((50.0, 2.6772, -79.7751), (50.0, 0.0, -82.7485), 2.0425),
    ((50.0, 3.1571, -77.2803), (50.0, 0.0, -82.7485), 2.8615),
    ((50.0, 2.8361, -74.0200), (50.0, 0.0, -82.7485), 3.4412),
    ((50.0, -1.3802, -84.2814), (50.0, 0.0, -82.7485), 1.0000),
    ((50.0, 0.0, 0.0), (50.0, -1.0, 2.0), 2.3669),
    ((50.0, 2.5, 0.0), (73.0, 25.0, -18.0), 27.1492),
    ((50.0, 2.5, 0.0), (61.0, -5.0, 29.0), 22.8977),
    ((60.2574, -34.0099, 36.2677), (60.4626, -34.1751, 39.4387), 1.2644),
    ((6.7747, -0.2908, -2.4247), (5.8714, -0.0985, -2.2286), 0.6377),
    ((2.0776, 0.0795, -1.1350), (0.9033, -0.0636, -0.5514), 0.9082),
)


@pytest.mark.parametrize(("first", "second", "expected"), PAIRS)
def test_published_pairs(first: tuple[float, ...], second: tuple[float, ...], expected: float) -> None:
    a, b = np.array(first), np.array(second)
    assert ciede2000(a, b) == pytest.approx(expected, abs=1e-4)
    assert ciede2000(b, a) == pytest.approx(expected, abs=1e-4)


def test_lab_of_known_colours() -> None:
    codes = np.array([[255, 255, 255], [0, 0, 0], [255, 0, 0], [119, 119, 119]], np.uint8)
    expected = [[100, 0, 0], [0, 0, 0], [53.24, 80.09, 67.20], [50.03, 0, 0]]
    np.testing.assert_allclose(lab_from_srgb(codes), expected, atol=0.03)
