from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, Protocol

import numpy as np
import pytest

from tests.errors import one_line
from warehouse_sim.api.arguments import checked, fits
from warehouse_sim.errors import InputError
from warehouse_sim.ranges import Range


class Shaped(Protocol):
    size: int


@pytest.mark.parametrize(
    ("value", "hint", "expected"),
    [
        (3, float, True),
        (np.float32(1.5), float, True),
        (True, float, False),
        (2.0, int, False),
        (np.int64(2), int, True),
        (1, bool, False),
        ("a", str | Path, True),
        (Path("a"), str | Path, True),
        (b"a", str | Path, False),
        (None, str | None, True),
        ("icp", Literal["icp"], True),
        ("ipc", Literal["icp"], False),
        (1, Literal[True], False),
        (["a", "b"], Sequence[str], True),
        ("ab", Sequence[str], False),
        (["a", 1], Sequence[str], False),
        ((1, 2), tuple[float, float], True),
        ((1, 2, 3), tuple[float, float], False),
        (np.ones(2), tuple[float, float], True),
        ((1, 2, 3), tuple[float, ...], True),
        ({"a": 1}, Mapping[str, int], True),
        ({"a": "b"}, dict[str, int], False),
        (len, Callable[[Any], int], True),
        (3, Callable[[Any], int], False),
        (3, Shaped, True),
        (3, Any, True),
        (3, Annotated[int, Range(0, 2)], True),
    ],
)
def test_a_value_is_of_a_type_or_not(value: Any, hint: Any, expected: bool) -> None:
    assert fits(value, hint) is expected


@checked
def place(x: float, *more: str, lift: Annotated[float, Range(0, 10, "m")] = 0.0, on: Path | None = None) -> float:
    return x + lift


@checked
def at(point: tuple[float, float] | Mapping[str, Any]) -> None:
    return None


def test_what_fits_is_passed_on() -> None:
    assert place(1, "a", lift=2) == 3
    assert place.__name__ == "place"


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: place(), "place: missing a required argument: 'x'; it takes x, *more, lift, on"),
        (lambda: place(1, "a\udc80"), "place: more[0] must be text that UTF-8 can hold, found 'a\\udc80'"),
        (lambda: place("1"), "place: x must be a number, found '1'"),
        (lambda: place(1, 2), "place: more[0] must be text, found 2"),
        (lambda: place(1, lfit=2), "did you mean 'lift'?"),
        (lambda: place(1, lift=11.0), "place: lift must be 0-10 m, found 11.0"),
        (lambda: place(float("nan")), "place: x must be finite, found nan"),
        (lambda: at((1, float("inf"))), "at: point must be finite, found (1, inf)"),
        (lambda: at("ab"), "at: point must be (a number, a number) or a mapping from text to anything, found 'ab'"),
        (lambda: place(1, on="floor"), "place: on must be a path or None, found 'floor'"),
    ],
)
def test_what_does_not_fit_is_said_in_one_line(call: Callable[[], Any], words: str) -> None:
    with one_line(InputError, words):
        call()


@pytest.mark.parametrize("path", ["", " ", "a\nb", "a\0b", 300 * "a", 2000 * "ab/"])
def test_a_path_that_no_file_has_is_rejected(path: str) -> None:
    @checked
    def opened(folder: str | Path) -> str:
        return str(folder)

    assert opened("a/b") == opened(Path("a/b")) == "a/b"
    with pytest.raises(InputError, match="opened: folder ") as caught:
        opened(path)
    assert "\n" not in str(caught.value)


def test_errors_from_within_are_not_touched() -> None:
    @checked
    def broken(x: int) -> None:
        raise TypeError("of its own")

    with pytest.raises(TypeError, match="of its own"):
        broken(1)
