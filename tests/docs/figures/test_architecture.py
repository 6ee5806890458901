"""The picture of the architecture is of the code: every room has its floor, and imports run down."""

from pathlib import Path

from docs.figures.architecture import PACKAGE, ROOT, draw_architecture, floors, imports, lines_of


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
