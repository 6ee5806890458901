from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import pytest

from warehouse_sim.errors import InputError
from warehouse_sim.signature import clear_arguments, clear_call


@clear_arguments
@dataclass(frozen=True)
class Box:
    width: float
    height: float = 1.0

    def __post_init__(self) -> None:
        if self.width == 13:
            raise TypeError("of its own")


@clear_call
def stack(box: Box, *more: Box, **options: Any) -> int:
    return 1 + len(more)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: Box(), "Box: missing a required argument: 'width'; it takes width, height"),
        (lambda: Box(1, heigth=2), "unexpected keyword argument 'heigth'; did you mean 'height'? it takes"),
        (lambda: Box(1, 2, 3), "Box: too many positional arguments"),
        (lambda: stack(), "stack: missing a required argument: 'box'; it takes box, *more, **options"),
    ],
)
def test_a_call_that_does_not_fit_says_what_does(call: Callable[[], Any], words: str) -> None:
    with pytest.raises(InputError) as caught:
        call()
    assert words in str(caught.value)


def test_other_calls_and_errors_are_as_before() -> None:
    assert Box(2) == Box(width=2, height=1.0)
    assert stack(Box(1), Box(2), tall=True) == 2
    with pytest.raises(TypeError, match="of its own"):
        Box(13)
